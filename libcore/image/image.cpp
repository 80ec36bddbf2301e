// SPDX-License-Identifier: Apache-2.0
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/image/image.hpp>
#include <triad/image/internal/oiio.hpp>

namespace triad {

Cells parse_cells(const std::string& text, const std::string& option) {
  const size_t cross = text.find('x');
  if (cross != std::string::npos) {
    const auto x = parse_int(std::string_view(text).substr(0, cross));
    const auto y = parse_int(std::string_view(text).substr(cross + 1));
    if (x && y && *x >= 1 && *x <= 64 && *y >= 1 && *y <= 64) return {static_cast<int>(*x), static_cast<int>(*y)};
  }
  throw_usage(option + ": '" + text + "' is not a number of cells per pixel; write e.g. 3x1, each side in 1..64");
}

Metadata::Metadata() : impl_(std::make_unique<Impl>()) {}
Metadata::~Metadata() = default;
Metadata::Metadata(const Metadata& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
// The source stays usable (empty), because no member function may meet a null pointer.
Metadata::Metadata(Metadata&& other) noexcept : impl_(std::make_unique<Impl>()) { impl_.swap(other.impl_); }
Metadata& Metadata::operator=(const Metadata& other) {
  if (this != &other) *impl_ = *other.impl_;
  return *this;
}
Metadata& Metadata::operator=(Metadata&& other) noexcept {
  impl_.swap(other.impl_);
  return *this;
}

std::optional<std::string> Metadata::get(const std::string& key) const {
  const auto it = impl_->list.find(key);
  if (it == impl_->list.cend()) return std::nullopt;
  return it->get_string();
}

void Metadata::set(const std::string& key, const std::string& value) { impl_->list.attribute(key, value); }
void Metadata::erase(const std::string& key) { impl_->list.remove(key); }

std::vector<std::pair<std::string, std::string>> Metadata::entries() const {
  std::vector<std::pair<std::string, std::string>> result;
  for (const auto& item : impl_->list) result.emplace_back(item.name().string(), item.get_string());
  return result;
}

std::string ImageSpec::size_text() const {
  std::string names;
  bool single_letters = true;
  for (const auto& name : channels) single_letters = single_letters && name.size() == 1;
  if (single_letters)
    for (const auto& name : channels) names += name;
  else
    names = join(channels, ",");
  return std::to_string(width) + "x" + std::to_string(height) + " " + names;
}

}  // namespace triad
