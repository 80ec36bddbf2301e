// SPDX-License-Identifier: Apache-2.0
#include <elf.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <triad/abi/triad_plugin.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <triad/base/log.hpp>
#include <triad/pipeline/plugin_error.hpp>
#include <triad/pipeline/plugin_file.hpp>

namespace triad {
namespace {

constexpr uint64_t kMaxFileBytes = uint64_t{1} << 30;  // far beyond any plugin; it is read whole
constexpr char kSymbolStem[] = "triad_library_v";
constexpr char kSymbol[] = "triad_library_v1";

#if defined(__x86_64__)
constexpr int kMachine = EM_X86_64;
#elif defined(__aarch64__)
constexpr int kMachine = EM_AARCH64;
#else
#error "plugins are known to work on x86-64 and AArch64 only"
#endif

// The file's bytes, with every access checked against its size.
class Bytes {
 public:
  explicit Bytes(std::vector<char> bytes) : bytes_(std::move(bytes)) {}
  uint64_t size() const { return bytes_.size(); }
  template <class T>
  bool read(uint64_t offset, T& out) const {
    if (offset > size() || size() - offset < sizeof(T)) return false;
    std::memcpy(&out, bytes_.data() + offset, sizeof(T));
    return true;
  }
  // The text at `offset`, or "" when it runs past the end.
  std::string text(uint64_t offset) const {
    if (offset >= size()) return {};
    const char* begin = bytes_.data() + offset;
    const size_t room = size() - offset;
    const size_t length = strnlen(begin, room);
    return length < room ? std::string(begin, length) : std::string();
  }

 private:
  std::vector<char> bytes_;
};

// The dynamic section, with its addresses turned into places in the file.
struct Dynamic {
  uint64_t symbols = 0, strings = 0, hash = 0, gnu_hash = 0;
  std::vector<uint64_t> search_paths;  // offsets into the strings
};

class DynamicReader {
 public:
  DynamicReader(const Bytes& file, const std::vector<Elf64_Phdr>& headers) : file_(file), headers_(headers) {}

  // Throws nothing: false when the file has no usable dynamic section.
  bool read(Dynamic& out) const {
    for (const Elf64_Phdr& header : headers_) {
      if (header.p_type != PT_DYNAMIC) continue;
      for (uint64_t at = header.p_offset; at + sizeof(Elf64_Dyn) <= header.p_offset + header.p_filesz;
           at += sizeof(Elf64_Dyn)) {
        Elf64_Dyn entry;
        if (!file_.read(at, entry) || entry.d_tag == DT_NULL) break;
        switch (entry.d_tag) {
          case DT_SYMTAB: out.symbols = place(entry.d_un.d_ptr); break;
          case DT_STRTAB: out.strings = place(entry.d_un.d_ptr); break;
          case DT_HASH: out.hash = place(entry.d_un.d_ptr); break;
          case DT_GNU_HASH: out.gnu_hash = place(entry.d_un.d_ptr); break;
          case DT_RPATH:
          case DT_RUNPATH: out.search_paths.push_back(entry.d_un.d_val); break;
          default: break;
        }
      }
    }
    return out.symbols && out.strings && (out.hash || out.gnu_hash);
  }

  // How many symbols there are: the table does not say, its hash does.
  uint64_t symbol_count(const Dynamic& dynamic) const {
    uint32_t head[4];
    if (dynamic.hash && file_.read(dynamic.hash, head)) return head[1];
    if (!dynamic.gnu_hash || !file_.read(dynamic.gnu_hash, head)) return 0;
    const uint64_t buckets = dynamic.gnu_hash + 16 + uint64_t{head[2]} * 8, chains = buckets + uint64_t{head[0]} * 4;
    uint64_t last = 0;
    for (uint64_t i = 0; i < head[0]; ++i) {
      uint32_t first;
      if (!file_.read(buckets + i * 4, first)) return 0;
      last = std::max<uint64_t>(last, first);
    }
    if (last < head[1]) return head[1];
    for (uint32_t word; file_.read(chains + (last - head[1]) * 4, word); ++last)
      if (word & 1) return last + 1;
    return 0;
  }

 private:
  uint64_t place(uint64_t address) const {
    for (const Elf64_Phdr& header : headers_)
      if (header.p_type == PT_LOAD && address >= header.p_vaddr && address - header.p_vaddr < header.p_filesz)
        return address - header.p_vaddr + header.p_offset;
    return 0;
  }
  const Bytes& file_;
  const std::vector<Elf64_Phdr>& headers_;
};

std::string with_rule(const std::string& rule, const std::string& stage, const std::string& file,
                      const std::string& what) {
  const std::string who = stage.empty() ? "plugin file '" + file + "'" : "plugin '" + stage + "' (" + file + ")";
  return printable(who + ": " + what + " [" + rule + "]");
}

}  // namespace

PluginError::PluginError(std::string rule, const std::string& stage, const std::string& file, std::string what)
    : Error(ErrorKind::kInput, with_rule(rule, stage, file, what)),
      rule_(std::move(rule)),
      finding_(std::move(what)) {}

void PluginFile::refuse(const char* rule, const std::string& what) const {
  throw PluginError(rule, "", real_path_, what);
}

PluginFile::PluginFile(const std::string& path, PathTrust trust) : real_path_(path) {
  const std::unique_ptr<char, decltype(&std::free)> real(realpath(path.c_str(), nullptr), &std::free);
  if (!real) {
    const int error = errno;
    struct stat link {};
    if (lstat(path.c_str(), &link) == 0 && S_ISLNK(link.st_mode))
      refuse("file.dangling-link", std::string("it is a link whose target cannot be reached: ") + strerror(error));
    refuse("file.missing", strerror(error));
  }
  real_path_ = real.get();
  struct stat before {};
  if (stat(real_path_.c_str(), &before) != 0) refuse("file.missing", strerror(errno));
  if (S_ISDIR(before.st_mode)) refuse("file.folder", "it is a folder; a plugin is a shared object, NAME.triad.so");
  if (!S_ISREG(before.st_mode)) refuse("file.kind", "it is not a regular file but a pipe, socket or device");
  descriptor_ = open(real_path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (descriptor_ < 0) refuse("file.unreadable", strerror(errno));
  try {
    struct stat info {};
    if (fstat(descriptor_, &info) != 0) refuse("file.unreadable", strerror(errno));
    if (!S_ISREG(info.st_mode)) refuse("file.kind", "it is not a regular file");
    device_ = info.st_dev;
    inode_ = info.st_ino;
    mode_ = info.st_mode;
    size_ = static_cast<uint64_t>(info.st_size);
    if (size_ == 0) refuse("file.empty", "it is empty");
    if (size_ > kMaxFileBytes) refuse("file.too-big", "it is larger than 1 GiB");
    check_permissions(trust);
    check_elf();
  } catch (...) {
    close(descriptor_);
    throw;
  }
}

PluginFile::~PluginFile() {
  if (owned_) close(descriptor_);
}

void PluginFile::check_permissions(PathTrust trust) const {
  std::string what;
  if (mode_ & S_IWOTH) what = "everybody may write to it";
  const std::string folder = real_path_.substr(0, std::max<size_t>(1, real_path_.rfind('/')));
  struct stat info {};
  if (what.empty() && stat(folder.c_str(), &info) == 0 && (info.st_mode & S_IWOTH)) {
    // In a sticky folder (/tmp) nobody can replace somebody else's file, so a path that was named is safe.
    if (trust == PathTrust::kImplicit || !(info.st_mode & S_ISVTX))
      what = "everybody may write to its folder '" + folder + "'";
  }
  if (what.empty()) return;
  if (trust == PathTrust::kImplicit)
    refuse("file.world-writable",
           what + "; a plugin runs with your rights: chmod o-w, or name it with --plugin-path");
  warn(PluginError("file.world-writable", "", real_path_, what + "; a plugin runs with your rights").what());
}

void PluginFile::check_elf() {
  std::vector<char> raw(size_);
  for (size_t done = 0; done < raw.size();) {
    const ssize_t got = pread(descriptor_, raw.data() + done, raw.size() - done, static_cast<off_t>(done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) refuse("file.unreadable", got < 0 ? strerror(errno) : "it became shorter while it was read");
    done += static_cast<size_t>(got);
  }
  if (raw.size() < SELFMAG || std::memcmp(raw.data(), ELFMAG, SELFMAG) != 0)
    refuse("file.not-elf", "it is not a shared object: it does not begin with an ELF header");
  if (raw.size() < EI_NIDENT) refuse("file.truncated", "it ends within its ELF header");
  if (raw[EI_CLASS] != ELFCLASS64 || raw[EI_DATA] != ELFDATA2LSB)
    refuse("file.elf-class", "it was built for another class of machine; this Triad loads 64-bit little-endian code");

  const Bytes file(std::move(raw));
  Elf64_Ehdr header;
  if (!file.read(0, header)) refuse("file.truncated", "it ends within its ELF header");
  if (header.e_machine != kMachine)
    refuse("file.elf-machine", "it was built for another processor (ELF machine " + std::to_string(header.e_machine) +
                                   ", this one is " + std::to_string(kMachine) + ")");
  if (header.e_type != ET_DYN)
    refuse("file.elf-type", "it is not a shared object (an object file or a program?); link it with -shared");
  std::vector<Elf64_Phdr> headers(header.e_phnum);
  for (size_t i = 0; i < headers.size(); ++i)
    if (header.e_phentsize != sizeof(Elf64_Phdr) || !file.read(header.e_phoff + i * sizeof(Elf64_Phdr), headers[i]))
      refuse("file.truncated", "it ends within its program headers");
  for (const Elf64_Phdr& segment : headers) {
    if (segment.p_type != PT_LOAD) continue;
    if (segment.p_offset > size_ || segment.p_filesz > size_ - segment.p_offset || segment.p_memsz > kMaxFileBytes ||
        segment.p_vaddr > UINT64_MAX - segment.p_memsz)
      refuse("file.truncated", "a segment lies past its end; was it copied whole?");
    segments_.push_back({segment.p_vaddr, segment.p_vaddr + segment.p_memsz, (segment.p_flags & PF_X) != 0});
  }
  if (header.e_shoff &&
      (header.e_shoff > size_ || uint64_t{header.e_shnum} * header.e_shentsize > size_ - header.e_shoff))
    refuse("file.truncated", "its section headers lie past its end; was it copied whole?");

  const DynamicReader reader(file, headers);
  Dynamic dynamic;
  if (segments_.empty() || !reader.read(dynamic))
    refuse("symbol.missing", std::string("it exports no symbols; a plugin exports ") + kSymbol);
  for (const uint64_t path : dynamic.search_paths)
    if (file.text(dynamic.strings + path).find("ORIGIN") != std::string::npos) uses_origin_ = true;
  const uint64_t count = reader.symbol_count(dynamic);
  std::string other;
  for (uint64_t i = 1; i < count; ++i) {
    Elf64_Sym symbol;
    if (!file.read(dynamic.symbols + i * sizeof(Elf64_Sym), symbol)) break;
    const std::string name = file.text(dynamic.strings + symbol.st_name);
    if (symbol.st_shndx == SHN_UNDEF || !name.starts_with(kSymbolStem)) continue;
    if (name != kSymbol) {
      other = name;
      continue;
    }
    if (ELF64_ST_TYPE(symbol.st_info) != STT_OBJECT)
      refuse("symbol.not-data", std::string(kSymbol) + " must be constant data, but is a function or something else");
    if (symbol.st_size < TRIAD_LIBRARY_SIZE_1_0)
      refuse("symbol.too-small", std::string(kSymbol) + " has " + std::to_string(symbol.st_size) +
                                     " bytes, a triad_library has at least " +
                                     std::to_string(TRIAD_LIBRARY_SIZE_1_0));
    symbol_value_ = symbol.st_value;
    symbol_size_ = symbol.st_size;
    return;
  }
  if (!other.empty())
    refuse("symbol.other-version",
           "it exports " + other + ", but this Triad needs " + kSymbol + "; build it against this Triad's headers");
  refuse("symbol.missing", std::string("it does not export ") + kSymbol + "; is it a Triad plugin?");
}

}  // namespace triad
