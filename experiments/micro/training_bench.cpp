// Training steps of a ViGAS network on the processor; experiments/peers/compare_training.py drives
// it beside a peer. Without options it prints the seconds of each of ten steps.
//
// usage: training_bench [--blocks N] [--layers N] [--channels N] [--picture PIXELS] [--clips N]
//                       [--threads N] [--save FOLDER] [--serve]
//   --layers   of each block
//   --picture  width and height of the image; 0: a network without an image trunk
//   --save     writes weights, inputs and gradients there, for a peer to compare with
//   --serve    reads "step" from standard input, and answers each with a line: seconds, and
//              processor seconds of all threads
#include "released_network.h"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <sys/resource.h>

#include <earpoint/core/parallel.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/network/weights.h>
#include <earpoint/train/vigas_learner.h>
#include <earpoint/vigas/description.h>

namespace {

namespace fs = std::filesystem;
using earpoint::SafetensorsFile;

constexpr double kLearningRate = 1e-5;  // small, so that the weights hardly change

struct Options {
  int blocks = 1;
  int layers = 10;
  int channels = 32;
  int picture_px = 256;
  int clips = 8;
  int threads = earpoint::available_cores();
  fs::path save;
  bool serve = false;
};

Options parse(const std::vector<std::string>& arguments) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& name = arguments[i];
    if (name == "--serve") {
      options.serve = true;
      continue;
    }
    if (i + 1 == arguments.size()) throw std::invalid_argument("unknown option " + name);
    const std::string& value = arguments[++i];
    if (name == "--blocks") {
      options.blocks = std::stoi(value);
    } else if (name == "--layers") {
      options.layers = std::stoi(value);
    } else if (name == "--channels") {
      options.channels = std::stoi(value);
    } else if (name == "--picture") {
      options.picture_px = std::stoi(value);
    } else if (name == "--clips") {
      options.clips = std::stoi(value);
    } else if (name == "--threads") {
      options.threads = std::stoi(value);
    } else if (name == "--save") {
      options.save = value;
    } else {
      throw std::invalid_argument("unknown option " + name);
    }
  }
  return options;
}

earpoint::ViGasDescription network_of(const Options& options) {
  earpoint::ViGasDescription network;
  network.blocks = options.blocks;
  network.layers_per_block = options.layers;
  network.channels = options.channels;
  network.pose_encoding = earpoint::PoseEncoding::full;
  network.box_encoding = earpoint::BoxEncoding::corners;
  if (options.picture_px > 0) {
    network.image_encoder = earpoint::ImageEncoderDescription{
        .width_px = options.picture_px, .height_px = options.picture_px, .channels = 8};
    network.inputs = {{"visual_feat", network.image_encoder->feature_width()}};
  }
  network.inputs.push_back({"tgt_pose", 3});
  network.inputs.push_back({"tgt_rotation", 6});
  network.inputs.push_back({"bboxes", 4});
  return network;
}

/// With a target for every clip: its source with exchanged ears.
SafetensorsFile training_inputs(const earpoint::ViGasDescription& network, std::int64_t clips) {
  SafetensorsFile inputs = earpoint::drawn_inputs(network, clips);
  const earpoint::Tensor& source = inputs.tensors.at("src_wav");
  const auto samples = static_cast<std::size_t>(source.shape[2]);
  const std::span<const float> values = source.as<float>();
  std::vector<float> target;
  for (std::size_t ear = 0; ear < values.size() / samples; ++ear) {
    const auto other = values.subspan((ear ^ 1U) * samples, samples);
    target.insert(target.end(), other.begin(), other.end());
  }
  inputs.tensors.emplace("tgt_wav", earpoint::make_tensor<float>(target, source.shape));
  return inputs;
}

earpoint::TrainingBatch batch_of(const SafetensorsFile& inputs) {
  earpoint::TrainingBatch batch;
  batch.clips = inputs.tensors.at("src_wav").shape[0];
  for (const auto& [name, tensor] : inputs.tensors) {
    const std::span<const float> values = tensor.as<float>();
    std::vector<float> copy(values.begin(), values.end());
    if (name == "src_wav") {
      batch.source = std::move(copy);
    } else if (name == "tgt_wav") {
      batch.target = std::move(copy);
    } else if (name == "src_rgb") {
      batch.pictures = std::move(copy);
    } else {
      batch.inputs[name] = std::move(copy);
    }
  }
  return batch;
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

Taken measure_step(earpoint::ViGasLearner& learner, const earpoint::TrainingBatch& batch) {
  const auto start = std::chrono::steady_clock::now();
  const double processor_start = processor_seconds();
  learner.compute_gradients(batch);
  learner.apply_gradients(kLearningRate);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  return {taken.count(), processor_seconds() - processor_start};
}

void save(const fs::path& folder, earpoint::ViGasLearner& learner, const SafetensorsFile& inputs) {
  fs::create_directories(folder);
  earpoint::write_safetensors(folder / "weights.safetensors",
                              earpoint::to_weight_file(learner.weights()));
  earpoint::write_safetensors(folder / "inputs.safetensors", inputs);
  learner.compute_gradients(batch_of(inputs));
  SafetensorsFile gradients;
  gradients.tensors = learner.gradients();
  earpoint::write_safetensors(folder / "gradients.safetensors", gradients);
}

void run(const Options& options) {
  earpoint::set_learner_threads(options.threads);
  const earpoint::ViGasWeights weights = earpoint::drawn_network(network_of(options));
  const SafetensorsFile inputs = training_inputs(weights.description, options.clips);
  const earpoint::TrainingBatch batch = batch_of(inputs);
  earpoint::ViGasLearner learner(weights);
  if (!options.save.empty()) save(options.save, learner, inputs);
  measure_step(learner, batch);
  if (options.serve) {
    std::cout << "ready" << std::endl;
    std::string name;
    while (std::getline(std::cin, name)) {
      const Taken taken = measure_step(learner, batch);
      std::cout << fmt::format("{:.9g} {:.9g}", taken.seconds, taken.processor_seconds)
                << std::endl;
    }
    return;
  }
  for (int step = 0; step < 10; ++step) {
    const Taken taken = measure_step(learner, batch);
    fmt::print("{:.3f} s, {:.2f} clips/s, {:.3f} processor s\n", taken.seconds,
               options.clips / taken.seconds, taken.processor_seconds);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(parse({argv + 1, argv + argc}));
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    fmt::print(stderr, "training_bench: {}\n", error.what());
    return EXIT_FAILURE;
  }
}
