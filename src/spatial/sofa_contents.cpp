#include "sofa_contents.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <mysofa.h>
#include <sys/wait.h>
#include <unistd.h>

#include <earpoint/core/platform/private_pipe.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr unsigned kTimeout_s = 10;  // the default set takes 0.1 s
constexpr int kRefused = 1;          // the child's exit status

// Flat form for the pipe: lengths as uint64, then bytes.
class Writer {
 public:
  void number(std::uint64_t value) { append(&value, sizeof(value)); }
  void text(std::string_view value) {
    number(value.size());
    append(value.data(), value.size());
  }
  void floats(const float* values, std::size_t count) {
    number(count);
    append(values, count * sizeof(float));
  }
  [[nodiscard]] std::span<const char> bytes() const { return bytes_; }

 private:
  void append(const void* data, std::size_t size) {
    const char* begin = static_cast<const char*>(data);
    bytes_.insert(bytes_.end(), begin, begin + size);
  }
  std::vector<char> bytes_;
};

// Its inverse. A child that reads a damaged file may send anything, so everything is checked.
class Parser {
 public:
  Parser(std::span<const char> bytes, std::string_view where) : bytes_(bytes), where_(where) {}
  std::uint64_t number() {
    std::uint64_t value = 0;
    std::memcpy(&value, take(sizeof(value)), sizeof(value));
    return value;
  }
  std::string text() {
    const std::uint64_t size = number();
    return {take(size), static_cast<std::size_t>(size)};
  }
  std::vector<float> floats() {
    const std::uint64_t count = number();
    check(count <= bytes_.size() / sizeof(float));
    std::vector<float> values(count);
    if (count > 0) std::memcpy(values.data(), take(count * sizeof(float)), count * sizeof(float));
    return values;
  }

 private:
  const char* take(std::uint64_t size) {
    check(size <= bytes_.size() - position_);
    position_ += size;
    return bytes_.data() + position_ - size;
  }
  void check(bool good) const {
    if (!good) throw InputError(where_, "the SOFA file is damaged");
  }
  std::span<const char> bytes_;
  std::string_view where_;
  std::size_t position_ = 0;
};

const char* attribute(const MYSOFA_ATTRIBUTE* entry, std::string_view name) {
  for (; entry != nullptr; entry = entry->next) {
    if (entry->name != nullptr && name == entry->name && entry->value != nullptr) {
      return entry->value;
    }
  }
  return "";
}

std::vector<std::pair<const char*, const MYSOFA_ARRAY*>> variables_of(const MYSOFA_HRTF& sofa) {
  return {
      {"ListenerPosition", &sofa.ListenerPosition},  {"ReceiverPosition", &sofa.ReceiverPosition},
      {"SourcePosition", &sofa.SourcePosition},      {"ListenerUp", &sofa.ListenerUp},
      {"ListenerView", &sofa.ListenerView},          {"Data.IR", &sofa.DataIR},
      {"Data.SamplingRate", &sofa.DataSamplingRate}, {"Data.Delay", &sofa.DataDelay}};
}

void write_contents(const MYSOFA_HRTF& sofa, Writer& writer) {
  writer.number(sofa.M);
  writer.number(sofa.R);
  writer.number(sofa.N);
  writer.text(attribute(sofa.attributes, "SOFAConventions"));
  writer.text(attribute(sofa.attributes, "DataType"));
  for (const auto& [name, array] : variables_of(sofa)) {
    writer.text(name);
    writer.floats(array->values, array->values == nullptr ? 0 : array->elements);
    writer.text(attribute(array->attributes, "Type"));
    writer.text(attribute(array->attributes, "Units"));
  }
}

// All that the child does.
[[noreturn]] void run_child(std::span<const std::byte> bytes, int to_parent) {
  // The parent's signal handlers must not run for a crash of the child.
  for (const int signal : {SIGABRT, SIGALRM, SIGBUS, SIGFPE, SIGILL, SIGSEGV}) {
    std::signal(signal, SIG_DFL);
  }
  alarm(kTimeout_s);
  // Messages that the C library prints before it aborts are not for the user.
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere >= 0) dup2(nowhere, STDERR_FILENO);
  int error = MYSOFA_OK;
  const MYSOFA_HRTF* sofa =
      mysofa_load_data(reinterpret_cast<const char*>(bytes.data()), bytes.size(), &error);
  if (sofa == nullptr) _exit(kRefused);
  Writer writer;
  write_contents(*sofa, writer);
  std::span<const char> rest = writer.bytes();
  while (!rest.empty()) {
    const ssize_t written = write(to_parent, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) _exit(kRefused);
    rest = rest.subspan(written);
  }
  _exit(0);
}

std::vector<char> read_to_end(int from_child) {
  std::vector<char> received;
  std::vector<char> block(1U << 16U);
  for (;;) {
    const ssize_t count = read(from_child, block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return received;
    received.insert(received.end(), block.begin(), block.begin() + count);
  }
}

}  // namespace

SofaContents parse_sofa_message(std::span<const char> message, std::string_view where) {
  Parser parser(message, where);
  SofaContents contents;
  contents.measurements = parser.number();
  contents.receivers = parser.number();
  contents.taps = parser.number();
  contents.convention = parser.text();
  contents.data_type = parser.text();
  for (std::size_t i = 0; i < variables_of(MYSOFA_HRTF{}).size(); ++i) {
    SofaVariable& variable = contents.variables[parser.text()];
    variable.values = parser.floats();
    variable.type = parser.text();
    variable.units = parser.text();
  }
  return contents;
}

SofaContents load_sofa_contents(std::span<const std::byte> bytes, std::string_view where) {
  const std::array<int, 2> ends = private_pipe();
  const pid_t child = fork();
  if (child < 0) {
    const int error = errno;
    close(ends[0]);
    close(ends[1]);
    throw std::system_error(error, std::generic_category(), "process for reading SOFA");
  }
  if (child == 0) run_child(bytes, ends[1]);
  close(ends[1]);
  const std::vector<char> received = read_to_end(ends[0]);
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw InputError(where, "the SOFA file is damaged, or not readable by libmysofa",
                     "use another set of head-related impulse responses");
  }
  return parse_sofa_message(received, where);
}

}  // namespace earpoint
