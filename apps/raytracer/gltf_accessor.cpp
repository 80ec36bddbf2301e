// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstring>
#include <triad/base/text.hpp>

#include "gltf.hpp"

namespace triad::raytracer::gltf {
namespace {

using tinygltf::Accessor;

// What no accessor may exceed. Those without data of their own (zeros, or sparse entries over zeros) cost a
// file nothing, so they are held to much less.
constexpr uint64_t kMostElements = uint64_t{1} << 31, kMostZeros = uint64_t{1} << 20;

// Bytes of `count` elements, `stride` apart, that lie wholly within their buffer.
struct Span {
  const unsigned char* data = nullptr;
  size_t stride = 0;
};

Span span_of(const File& file, int view_index, size_t offset, size_t count, size_t element_bytes,
             const std::string& user) {
  const auto& view = file.at(file.model.bufferViews, view_index, "buffer view", user);
  const auto& buffer = file.at(file.model.buffers, view.buffer, "buffer",
                               describe("buffer view", static_cast<size_t>(view_index), view.name));
  const size_t stride = view.byteStride == 0 ? element_bytes : view.byteStride;
  const size_t size = buffer.data.size();
  if (view.byteOffset > size || view.byteLength > size - view.byteOffset)
    file.fail(user + " is out of bounds: its buffer view needs bytes up to " +
              format_double(static_cast<double>(view.byteOffset) + static_cast<double>(view.byteLength)) +
              ", its buffer has " + std::to_string(size));
  const double needed = static_cast<double>(offset) + static_cast<double>(stride) * static_cast<double>(count - 1) +
                        static_cast<double>(element_bytes);  // exact below 2^53; no overflow above
  if (needed > static_cast<double>(view.byteLength))
    file.fail(user + " is out of bounds: it needs " + format_double(needed) + " bytes, its buffer view has " +
              std::to_string(view.byteLength));
  return {buffer.data.data() + view.byteOffset + offset, stride};
}

size_t component_bytes(const File& file, int type, const std::string& user) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT: return 4;
    default: file.fail(user + " has components of type " + std::to_string(type) + ", which glTF does not allow");
  }
}

template <typename T>
T load(const unsigned char* data) {
  T value;
  std::memcpy(&value, data, sizeof value);
  return value;
}

// glTF 2.0, section 3.11: normalised signed integers map to max(c / most, -1).
template <typename T>
void widen(Span in, size_t count, size_t components, bool normalised, float* out) {
  constexpr float kMost = static_cast<float>(std::numeric_limits<T>::max());
  for (size_t i = 0; i < count; ++i)
    for (size_t c = 0; c < components; ++c) {
      const auto value = static_cast<float>(load<T>(in.data + i * in.stride + c * sizeof(T)));
      *out++ = normalised ? std::max(value / kMost, -1.f) : value;
    }
}

void decode(Span in, int type, size_t count, size_t components, bool normalised, float* out) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: return widen<int8_t>(in, count, components, normalised, out);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return widen<uint8_t>(in, count, components, normalised, out);
    case TINYGLTF_COMPONENT_TYPE_SHORT: return widen<int16_t>(in, count, components, normalised, out);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return widen<uint16_t>(in, count, components, normalised, out);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return widen<uint32_t>(in, count, components, normalised, out);
    default: break;
  }
  const size_t row = components * sizeof(float);
  if (in.stride == row) {
    std::memcpy(out, in.data, count * row);
  } else {
    for (size_t i = 0; i < count; ++i) std::memcpy(out + i * components, in.data + i * in.stride, row);
  }
}

std::vector<uint32_t> decode_indices(const File& file, Span in, int type, size_t count, uint64_t limit,
                                     const std::string& user) {
  std::vector<uint32_t> indices(count);
  for (size_t i = 0; i < count; ++i) {
    const unsigned char* at = in.data + i * in.stride;
    switch (type) {
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: indices[i] = *at; break;
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: indices[i] = load<uint16_t>(at); break;
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: indices[i] = load<uint32_t>(at); break;
      default: file.fail(user + " is not made of unsigned integers");
    }
    if (indices[i] >= limit)
      file.fail(user + " is wrong: entry " + std::to_string(i) + " is " + std::to_string(indices[i]) +
                ", past the end (" + std::to_string(limit) + " elements)");
  }
  return indices;
}

const Accessor& accessor_of(const File& file, int index, int components, const std::string& user) {
  const Accessor& accessor = file.at(file.model.accessors, index, "accessor", user);
  const bool vector = accessor.type == TINYGLTF_TYPE_SCALAR || accessor.type == TINYGLTF_TYPE_VEC2 ||
                      accessor.type == TINYGLTF_TYPE_VEC3 || accessor.type == TINYGLTF_TYPE_VEC4;
  if (!vector || tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type)) != components)
    file.fail(user + " must have " + std::to_string(components) + " component" + (components == 1 ? "" : "s") +
              ", but accessor " + std::to_string(index) + " has another shape");
  const bool zeros = accessor.bufferView < 0;
  if (accessor.count == 0 || accessor.count > (zeros ? kMostZeros : kMostElements))
    file.fail(user + " has " + std::to_string(accessor.count) + " elements; from 1 to " +
              std::to_string(zeros ? kMostZeros : kMostElements) + " are possible" +
              (zeros ? " where there is no buffer view" : ""));
  return accessor;
}

// Replaces some elements (glTF 2.0, section 3.6.2.3).
void apply_sparse(const File& file, const Accessor& accessor, size_t components, const std::string& user,
                  std::vector<float>& values) {
  const auto& sparse = accessor.sparse;
  const std::string whose = "the sparse part of " + user;
  if (sparse.count < 1 || static_cast<size_t>(sparse.count) > accessor.count)
    file.fail(whose + " has " + std::to_string(sparse.count) + " elements of " + std::to_string(accessor.count));
  if (sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0) file.fail(whose + " begins before its buffer");
  const auto count = static_cast<size_t>(sparse.count);
  const Span places = span_of(file, sparse.indices.bufferView, static_cast<size_t>(sparse.indices.byteOffset), count,
                              component_bytes(file, sparse.indices.componentType, whose), whose);
  const std::vector<uint32_t> indices =
      decode_indices(file, places, sparse.indices.componentType, count, accessor.count, whose);
  const size_t bytes = components * component_bytes(file, accessor.componentType, whose);
  const Span span =
      span_of(file, sparse.values.bufferView, static_cast<size_t>(sparse.values.byteOffset), count, bytes, whose);
  std::vector<float> changed(count * components);
  decode(span, accessor.componentType, count, components, accessor.normalized, changed.data());
  for (size_t i = 0; i < count; ++i)
    std::copy_n(changed.data() + i * components, components, values.data() + indices[i] * components);
}

}  // namespace

std::vector<float> read_floats(const File& file, int index, int components, const std::string& user) {
  const Accessor& accessor = accessor_of(file, index, components, user);
  const auto width = static_cast<size_t>(components);
  const size_t bytes = width * component_bytes(file, accessor.componentType, user);
  std::vector<float> values;
  if (accessor.bufferView >= 0) {
    const Span span = span_of(file, accessor.bufferView, accessor.byteOffset, accessor.count, bytes, user);
    values.resize(accessor.count * width);
    decode(span, accessor.componentType, accessor.count, width, accessor.normalized, values.data());
  } else {
    values.resize(accessor.count * width);
  }
  if (accessor.sparse.isSparse) apply_sparse(file, accessor, width, user, values);
  for (size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i])) file.fail(user + " is not finite: element " + std::to_string(i / width));
  return values;
}

std::vector<uint32_t> read_indices(const File& file, int index, uint64_t limit, const std::string& user) {
  const Accessor& accessor = accessor_of(file, index, 1, user);
  if (accessor.sparse.isSparse) file.fail(user + " is sparse, which Triad does not read for indices");
  const Span span = span_of(file, accessor.bufferView, accessor.byteOffset, accessor.count,
                            component_bytes(file, accessor.componentType, user), user);
  return decode_indices(file, span, accessor.componentType, accessor.count, limit, user);
}

}  // namespace triad::raytracer::gltf
