#include <earpoint/train/process_group.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <utility>

#include <ATen/ops/from_blob.h>
#include <c10/util/Logging.h>
#include <c10/util/intrusive_ptr.h>
#include <fmt/format.h>
#include <torch/csrc/distributed/c10d/PrefixStore.hpp>
#include <torch/csrc/distributed/c10d/ProcessGroupGloo.hpp>
#include <torch/csrc/distributed/c10d/TCPStore.hpp>

#include <earpoint/error.h>

namespace earpoint {
namespace {

using c10d::ProcessGroupGloo;

/// The first line of an error, as c10 appends a stack trace.
std::string first_line(const std::exception& error) {
  const std::string text = error.what();
  return text.substr(0, text.find('\n'));
}

template <typename Action>
auto explained(const std::string& what, const std::string& hint, const Action& action) {
  try {
    return action();
  } catch (const std::exception& error) {
    throw InputError("training in several processes",
                     fmt::format("{}: {}", what, first_line(error)), hint);
  }
}

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(
      std::chrono::duration<double>(seconds));
}

/// The network device by which other processes reach this one.
std::shared_ptr<::gloo::transport::Device> device_for(const ProcessPlace& place) {
  if (place.local_processes == place.processes) {
    return ProcessGroupGloo::createDeviceForHostname("127.0.0.1");
  }
  // The variable that PyTorch uses.
  const char* interface = std::getenv("GLOO_SOCKET_IFNAME");
  return interface != nullptr ? ProcessGroupGloo::createDeviceForInterface(interface)
                              : ProcessGroupGloo::createDefaultDevice();
}

c10::intrusive_ptr<c10d::Store> meeting_place(const ProcessPlace& place,
                                              std::chrono::milliseconds patience) {
  c10d::TCPStoreOptions options;
  options.port = place.port;
  options.isServer = place.rank == 0 && !place.is_kept_by_launcher;
  options.numWorkers = static_cast<std::size_t>(place.processes);
  options.timeout = patience;
  options.waitWorkers = false;  // gives up waiting without a word
  const std::string prefix = place.key_prefix.empty() ? "earpoint" : place.key_prefix;
  c10::intrusive_ptr<c10d::Store> store = c10::make_intrusive<c10d::PrefixStore>(
      prefix, c10::make_intrusive<c10d::TCPStore>(place.address, options));
  store->set(fmt::format("here/{}", place.rank), std::vector<std::uint8_t>{1});
  std::vector<std::string> all;
  for (int rank = 0; rank < place.processes; ++rank) all.push_back(fmt::format("here/{}", rank));
  store->wait(all, patience);
  return store;
}

template <typename Number>
at::Tensor tensor_of(std::span<Number> values) {
  return at::from_blob(values.data(), {std::ssize(values)},
                       at::TensorOptions().dtype(c10::CppTypeToScalarType<Number>::value));
}

}  // namespace

struct ProcessGroup::State {
  template <typename Number>
  void sum(std::span<Number> values) {
    if (values.empty()) return;
    std::vector<at::Tensor> tensors{tensor_of(values)};
    wait_for([&] { return group->allreduce(tensors); });
  }

  void from_first(std::span<std::uint8_t> values) {
    if (values.empty()) return;
    std::vector<at::Tensor> tensors{tensor_of(values)};
    wait_for([&] { return group->broadcast(tensors); });
  }

  template <typename Start>
  static void wait_for(const Start& start) {
    explained("another process was lost", "see its output; then resume the training",
              [&] { start()->wait(); });
  }

  c10::intrusive_ptr<ProcessGroupGloo> group;
};

ProcessGroup::ProcessGroup(const ProcessPlace& place, double patience_s, double answer_s)
    : state_(std::make_unique<State>()) {
  explained(
      fmt::format("process {} of {} cannot meet the others at {}:{}", place.rank, place.processes,
                  place.address, place.port),
      "are MASTER_ADDR and MASTER_PORT right, is the port free, and have all been started?", [&] {
        auto options = ProcessGroupGloo::Options::create(milliseconds(answer_s));
        options->devices.push_back(device_for(place));
        state_->group = c10::make_intrusive<ProcessGroupGloo>(
            meeting_place(place, milliseconds(patience_s)), place.rank, place.processes, options);
        double all_here = 1.0;
        sum(std::span(&all_here, 1));
      });
}

ProcessGroup::~ProcessGroup() = default;

int ProcessGroup::rank() const { return state_->group->getRank(); }

int ProcessGroup::size() const { return state_->group->getSize(); }

void ProcessGroup::sum(std::span<float> values) { state_->sum(values); }

void ProcessGroup::sum(std::span<double> values) { state_->sum(values); }

std::vector<std::byte> ProcessGroup::from_first(std::vector<std::byte> bytes) {
  double size = is_first() ? static_cast<double>(bytes.size()) : 0.0;
  sum(std::span(&size, 1));
  bytes.resize(static_cast<std::size_t>(size));
  state_->from_first({reinterpret_cast<std::uint8_t*>(bytes.data()), bytes.size()});
  return bytes;
}

}  // namespace earpoint
