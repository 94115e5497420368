#include <earpoint/serve/limited_process.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <optional>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <earpoint/core/platform/private_pipe.h>

namespace earpoint {
namespace {

constexpr std::size_t kMostErrors = 4096;
constexpr int kNoProgram = 127;

/// @param what  RLIMIT_..., whose type is each C library's own
template <typename Resource>
void limit(Resource what, rlim_t most) {
  const rlimit both{most, most};
  setrlimit(what, &both);
}

/// Turns the child into the other program. Makes only calls that are safe after fork().
[[noreturn]] void become(const char* program, char* const* arguments, const ProcessLimits& limits,
                         int errors) {
  setpgid(0, 0);
  // SIGXCPU at the first limit, which tells why it ended; SIGKILL at the second.
  const auto seconds = static_cast<rlim_t>(limits.processor_time.count());
  const rlimit processor_time{seconds, seconds + 1};
  setrlimit(RLIMIT_CPU, &processor_time);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  limit(RLIMIT_AS, limits.memory_bytes);  // sanitizers reserve terabytes
#endif
  limit(RLIMIT_FSIZE, limits.file_bytes);
  limit(RLIMIT_CORE, 0);
  const int nowhere = open("/dev/null", O_RDWR | O_CLOEXEC);
  dup2(nowhere, STDIN_FILENO);
  dup2(nowhere, STDOUT_FILENO);
  dup2(errors, STDERR_FILENO);
  execv(program, arguments);
  _exit(kNoProgram);
}

/// Waits for the process to end.
/// @return nothing if that took too long
std::optional<int> wait_until(pid_t child, std::chrono::steady_clock::time_point end) {
  for (;;) {
    int status = 0;
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended == child) return status;
    if (std::chrono::steady_clock::now() > end) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

/// Reads until the other end is closed.
/// @return false if that took too long
bool read_errors(int from, std::chrono::steady_clock::time_point end, std::string& errors) {
  std::array<char, 1024> block;
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    pollfd waiting{from, POLLIN, 0};
    const int ready = poll(&waiting, 1, static_cast<int>(left.count()));
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    const ssize_t count = read(from, block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return true;
    errors.append(block.data(),
                  std::min(static_cast<std::size_t>(count), kMostErrors - errors.size()));
  }
}

}  // namespace

ProcessEnd run_limited(const std::filesystem::path& program,
                       const std::vector<std::string>& arguments, const ProcessLimits& limits) {
  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);

  const std::array<int, 2> ends = private_pipe();
  const pid_t child = fork();
  if (child == 0) become(pointers.front(), pointers.data(), limits, ends[1]);
  const int fork_error = errno;
  close(ends[1]);
  if (child < 0) {
    close(ends[0]);
    throw std::system_error(fork_error, std::generic_category(), "process");
  }

  setpgid(child, child);  // in both processes, as either may be first

  ProcessEnd end;
  const auto deadline = std::chrono::steady_clock::now() + limits.wall_time;
  std::optional<int> status;
  if (read_errors(ends[0], deadline, end.errors)) status = wait_until(child, deadline);
  close(ends[0]);
  if (!status) {
    end.is_out_of_time = true;
    kill(-child, SIGKILL);
    int killed = 0;
    while (waitpid(child, &killed, 0) < 0 && errno == EINTR) {
    }
    return end;
  }
  if (WIFEXITED(*status)) end.exit_code = WEXITSTATUS(*status);
  end.is_out_of_time = WIFSIGNALED(*status) && WTERMSIG(*status) == SIGXCPU;
  return end;
}

}  // namespace earpoint
