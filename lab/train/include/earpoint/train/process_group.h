#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace earpoint {

/// Which of several processes this one is, and where they meet.
struct ProcessPlace {
  int rank = 0;                       ///< 0 to processes - 1
  int processes = 1;                  ///< that learn together
  int local_processes = 1;            ///< of them on this machine; 1 where that is not told
  std::string address = "127.0.0.1";  ///< of the machine of process 0
  std::uint16_t port = 29500;
  /// torchrun keeps the meeting place itself; else process 0 does.
  bool is_kept_by_launcher = false;
  std::string key_prefix;  ///< of this start, where the launcher keeps the meeting place
};

/// Reads the place that a launcher has put into the environment: torchrun (WORLD_SIZE, RANK,
/// LOCAL_WORLD_SIZE), Open MPI, MPICH and Intel MPI, or srun; with MASTER_ADDR and MASTER_PORT for
/// where to meet. Those may be left out where all processes are on one machine.
/// @param variable  the value of an environment variable, or nothing
/// @return nothing if this process is alone
/// @throws InputError naming the variable that is missing or malformed
[[nodiscard]] std::optional<ProcessPlace> process_place(
    const std::function<std::optional<std::string>(const std::string&)>& variable);

/// The same from this process's environment.
[[nodiscard]] std::optional<ProcessPlace> process_place();

/// Processes that learn together, by LibTorch's c10d over Gloo. Every process of the group must
/// make the same calls in the same order, each with as many numbers; a call ends when all have made
/// it.
///
/// All calls throw InputError if another process has ended or does not answer.
class ProcessGroup {
 public:
  /// Waits until all processes have come.
  /// @param patience_s  that they may take to come
  /// @param answer_s    that they may take to make a call that this one has made
  /// @throws InputError if some do not come
  explicit ProcessGroup(const ProcessPlace& place, double patience_s = 300.0,
                        double answer_s = 1800.0);
  ~ProcessGroup();
  ProcessGroup(const ProcessGroup&) = delete;
  ProcessGroup& operator=(const ProcessGroup&) = delete;

  [[nodiscard]] int rank() const;
  [[nodiscard]] int size() const;
  /// Whether this one writes files and reports progress.
  [[nodiscard]] bool is_first() const { return rank() == 0; }

  /// Adds up over all processes, in place, to the same bits in all.
  void sum(std::span<float> values);
  void sum(std::span<double> values);

  /// @return what the first process has given, in every process
  [[nodiscard]] std::vector<std::byte> from_first(std::vector<std::byte> bytes);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
