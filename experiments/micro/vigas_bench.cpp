// One second of sound through the released network, in parts and as a whole, and the processor's
// peak beside it. Without options it prints JSON; experiments/peers/compare_vigas.py drives it
// beside its peers.
//
// usage: vigas_bench [--threads N] [--rounds N] [--save FOLDER] [--serve]
//   --save    writes weights, inputs and outputs there, for a peer to compare with
//   --serve   reads the names of measurements from standard input, one a line, and answers each
//             with a line: seconds, and processor seconds of all threads (for "peak": GFLOP/s)
#include "fma_peak.h"
#include "released_network.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include <earpoint/core/parallel.h>
#include <earpoint/network/weights.h>
#include <earpoint/vigas/description.h>
#include <earpoint/vigas/engine.h>

namespace {

namespace fs = std::filesystem;
using earpoint::ViGasDescription;

struct Options {
  int threads = earpoint::available_cores();
  int rounds = 20;
  fs::path save;
  bool serve = false;
};

Options parse(const std::vector<std::string>& arguments) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] == "--serve") {
      options.serve = true;
    } else if (i + 1 < arguments.size() && arguments[i] == "--threads") {
      options.threads = std::stoi(arguments[++i]);
    } else if (i + 1 < arguments.size() && arguments[i] == "--rounds") {
      options.rounds = std::stoi(arguments[++i]);
    } else if (i + 1 < arguments.size() && arguments[i] == "--save") {
      options.save = arguments[++i];
    } else {
      throw std::invalid_argument("unknown option " + arguments[i]);
    }
  }
  return options;
}

/// Multiplications and additions of the gated stack in its direct form: every tap of every output,
/// also those that see only padding, and nothing else.
double direct_operations(const ViGasDescription& network) {
  const double channels = network.channels;
  const double convolution = 2.0 * channels * channels * network.kernel_size;
  const double residual_and_skip = 2.0 * channels * channels;
  return 2.0 * network.layers() * (convolution + residual_and_skip) * network.window_samples;
}

/// The same without the taps that see only padding.
double live_operations(const ViGasDescription& network) {
  double taps = 0.0;  // summed over layers and samples
  for (int layer = 0; layer < network.layers(); ++layer) {
    const double samples = network.window_samples;
    taps += samples + 2.0 * std::max(0.0, samples - network.dilation(layer));
  }
  const double channels = network.channels;
  return 2.0 * 2.0 * channels * channels *
         (taps + static_cast<double>(network.layers()) * network.window_samples);
}

struct Taken {
  double seconds = 0.0;
  double processor_seconds = 0.0;  ///< of all threads together
};

/// Of this process, so far.
double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

class Bench {
 public:
  explicit Bench(const Options& options)
      : threads_(options.threads),
        weights_(earpoint::released_network()),
        inputs_(earpoint::drawn_inputs(weights_.description, 1)),
        network_(weights_, options.threads),
        fused_(weights_.description.conditioning_width),
        output_(floats("src_wav").size()) {
    run_whole();
    if (!options.save.empty()) save(options.save);
  }

  /// The best instruction set's peak.
  [[nodiscard]] double measure_peak() const {
    double best = 0.0;
    for (const earpoint::FmaPeak& peak : earpoint::measure_fma_peaks(threads_)) {
      best = std::max(best, peak.gflops);
    }
    return best;
  }

  Taken measure(const std::string& name) {
    const double processor_start = processor_seconds();
    const auto start = std::chrono::steady_clock::now();
    if (name == "whole") {
      run_whole();
    } else if (name == "stack") {
      network_.synthesize(floats("src_wav"), fused_, output_);
    } else if (name == "trunk") {
      feature_ = network_.image_feature(floats("src_rgb"));
    } else if (name == "fusion") {
      fuse();
    } else {
      throw std::invalid_argument("unknown measurement " + name);
    }
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    return {taken.count(), processor_seconds() - processor_start};
  }

  [[nodiscard]] const ViGasDescription& network() const { return weights_.description; }

 private:
  [[nodiscard]] std::span<const float> floats(const std::string& name) const {
    return inputs_.tensors.at(name).as<float>();
  }

  void fuse() {
    const std::vector<earpoint::ConditioningValues> values = {
        {"visual_feat", feature_},
        {"tgt_pose", floats("tgt_pose")},
        {"tgt_rotation", floats("tgt_rotation")},
        {"bboxes", floats("bboxes")}};
    network_.fuse(values, fused_);
  }

  void run_whole() {
    feature_ = network_.image_feature(floats("src_rgb"));
    fuse();
    network_.synthesize(floats("src_wav"), fused_, output_);
  }

  void save(const fs::path& folder) const {
    fs::create_directories(folder);
    earpoint::write_safetensors(folder / "weights.safetensors", earpoint::to_weight_file(weights_));
    earpoint::write_safetensors(folder / "inputs.safetensors", inputs_);
    earpoint::SafetensorsFile outputs;
    outputs.tensors.emplace(
        "pred", earpoint::make_tensor<float>(output_, inputs_.tensors.at("src_wav").shape));
    earpoint::write_safetensors(folder / "outputs.safetensors", outputs);
  }

  int threads_;
  earpoint::ViGasWeights weights_;
  earpoint::SafetensorsFile inputs_;
  earpoint::ViGas network_;
  std::vector<float> feature_;
  std::vector<float> fused_;
  std::vector<float> output_;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void serve(Bench& bench) {
  std::cout << "ready " << direct_operations(bench.network()) << ' '
            << live_operations(bench.network()) << std::endl;
  std::string name;
  while (std::getline(std::cin, name)) {
    if (name == "peak") {
      std::cout << fmt::format("{:.9g}", bench.measure_peak()) << std::endl;
    } else {
      const Taken taken = bench.measure(name);
      std::cout << fmt::format("{:.9g} {:.9g}", taken.seconds, taken.processor_seconds)
                << std::endl;
    }
  }
}

void report(Bench& bench, const Options& options) {
  std::map<std::string, std::vector<double>> taken;
  for (int round = 0; round < options.rounds; ++round) {
    taken["peak"].push_back(bench.measure_peak());
    for (const char* name : {"trunk", "fusion", "stack", "whole"}) {
      taken[name].push_back(bench.measure(name).seconds);
    }
  }
  nlohmann::ordered_json json;
  json["threads"] = options.threads;
  for (const earpoint::FmaPeak& peak : earpoint::measure_fma_peaks(options.threads)) {
    json["fma_peak_gflops"][peak.instruction_set] = peak.gflops;
  }
  for (const char* name : {"trunk", "fusion", "stack", "whole"}) {
    json["median_ms"][name] = 1e3 * median(taken[name]);
    json["least_ms"][name] = 1e3 * *std::min_element(taken[name].begin(), taken[name].end());
  }
  const double peak = median(taken["peak"]);
  const double stack = median(taken["stack"]);
  const double direct = direct_operations(bench.network()) / 1e9;
  const double live = live_operations(bench.network()) / 1e9;
  json["median_fma_peak_gflops"] = peak;
  json["direct_gflop"] = direct;
  json["direct_gflop_without_padding"] = live;
  json["stack_gflops_direct"] = direct / stack;
  json["stack_gflops_direct_without_padding"] = live / stack;
  json["stack_fraction_of_peak"] = direct / stack / peak;
  json["stack_fraction_of_peak_without_padding"] = live / stack / peak;
  fmt::print("{}\n", json.dump(2));
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Options options = parse({argv + 1, argv + argc});
    Bench bench(options);
    if (options.serve) {
      serve(bench);
    } else {
      report(bench, options);
    }
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    fmt::print(stderr, "vigas_bench: {}\n", error.what());
    return EXIT_FAILURE;
  }
}
