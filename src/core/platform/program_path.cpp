#include <earpoint/core/platform/program_path.h>

#include <system_error>

namespace earpoint {
namespace {

constexpr const char* kRunning = "/proc/self/exe";

}  // namespace

std::filesystem::path program_path() {
  std::error_code unknown;
  return std::filesystem::read_symlink(kRunning, unknown);
}

std::filesystem::path running_program() { return kRunning; }

}  // namespace earpoint
