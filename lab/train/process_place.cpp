#include <array>
#include <charconv>
#include <cstdlib>
#include <limits>
#include <system_error>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/train/process_group.h>

namespace earpoint {
namespace {

using Variables = std::function<std::optional<std::string>(const std::string&)>;

/// A launcher's environment variables; empty if it has none for a value.
struct Launcher {
  const char* size;
  const char* rank;
  const char* local_size;
};

// srun sets the SLURM_STEP_ variables for what it starts; a batch script's own shell has none.
constexpr std::array<Launcher, 4> kLaunchers{
    {{"WORLD_SIZE", "RANK", "LOCAL_WORLD_SIZE"},
     {"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_LOCAL_SIZE"},
     {"PMI_SIZE", "PMI_RANK", "MPI_LOCALNRANKS"},
     {"SLURM_STEP_NUM_TASKS", "SLURM_PROCID", ""}}};

constexpr int kMostProcesses = 1 << 20;

int number_in(const std::string& name, const std::string& text, int least, int most) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && value >= least && value <= most) {
    return value;
  }
  throw InputError(name, fmt::format("expected {} to {}, found '{}'", least, most, text),
                   "unset it to train in one process");
}

std::string required(const Variables& variable, const std::string& name, const char* given) {
  if (std::optional<std::string> text = variable(name)) return *std::move(text);
  throw InputError(name, fmt::format("is not set, but {} is", given),
                   fmt::format("set it, or unset {} to train in one process", given));
}

bool is_on_one_machine(const Variables& variable, const ProcessPlace& place) {
  if (place.local_processes == place.processes) return true;
  return variable("SLURM_STEP_NUM_NODES").value_or("") == "1";
}

}  // namespace

std::optional<ProcessPlace> process_place(const Variables& variable) {
  for (const Launcher& launcher : kLaunchers) {
    const std::optional<std::string> size = variable(launcher.size);
    if (!size) continue;
    ProcessPlace place;
    place.processes = number_in(launcher.size, *size, 1, kMostProcesses);
    if (place.processes == 1) return std::nullopt;
    place.rank = number_in(launcher.rank, required(variable, launcher.rank, launcher.size), 0,
                           place.processes - 1);
    if (const auto local = variable(launcher.local_size)) {
      place.local_processes = number_in(launcher.local_size, *local, 1, place.processes);
    }
    if (is_on_one_machine(variable, place)) place.local_processes = place.processes;
    if (const auto address = variable("MASTER_ADDR")) {
      place.address = *address;
    } else if (place.local_processes != place.processes) {
      place.address = required(variable, "MASTER_ADDR", launcher.size);
    }
    if (place.address == "127.0.0.1" || place.address == "localhost") {
      place.local_processes = place.processes;
    }
    if (const auto port = variable("MASTER_PORT")) {
      place.port = static_cast<std::uint16_t>(
          number_in("MASTER_PORT", *port, 1, std::numeric_limits<std::uint16_t>::max()));
    }
    if (variable("TORCHELASTIC_USE_AGENT_STORE").value_or("") == "True") {
      place.is_kept_by_launcher = true;
      place.key_prefix = "/worker/attempt_" + variable("TORCHELASTIC_RESTART_COUNT").value_or("0");
    }
    return place;
  }
  return std::nullopt;
}

std::optional<ProcessPlace> process_place() {
  return process_place([](const std::string& name) -> std::optional<std::string> {
    const char* value = name.empty() ? nullptr : std::getenv(name.c_str());
    if (value == nullptr) return std::nullopt;
    return value;
  });
}

}  // namespace earpoint
