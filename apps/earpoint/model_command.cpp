#include "model_command.h"

#include "json_text.h"
#include "model_run_command.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/gtf/training_range.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/network/checked_tensors.h>
#include <earpoint/network/network_kind.h>
#include <earpoint/people/weights.h>
#include <earpoint/rt60/weights.h>
#include <earpoint/vam/weights.h>
#include <earpoint/vigas/checkpoint_export.h>
#include <earpoint/vigas/weights.h>
#include <earpoint/weights/checkpoint.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

struct ImportArguments {
  fs::path checkpoint;
  fs::path output;
  bool keep_all = false;
};

struct ExportOptions {
  fs::path file;
  fs::path output;
};

struct RangeOptions {
  fs::path file;
  std::string range = "{}";
  fs::path output;
};

struct InfoOptions {
  fs::path file;
  bool json = false;
};

std::int64_t value_count(const std::map<std::string, Tensor>& tensors) {
  std::int64_t count = 0;
  for (const auto& [name, tensor] : tensors) count += tensor.elements();
  return count;
}

void import_model(const ImportArguments& options) {
  const std::string where = options.checkpoint.string();
  Checkpoint checkpoint = import_checkpoint(options.checkpoint);
  const std::size_t found = checkpoint.state_dict.size();
  const SafetensorsFile file = weight_file_from_checkpoint(
      std::move(checkpoint), options.keep_all ? KeepTensors::all : KeepTensors::required, where);
  write_safetensors(options.output, file);
  fmt::print("wrote {}: {} tensors, {} values", options.output.string(), file.tensors.size(),
             value_count(file.tensors));
  if (file.tensors.size() < found) {
    fmt::print("; dropped {} tensors that inference does not use (--keep-all keeps them)",
               found - file.tensors.size());
  }
  fmt::print("\n");
}

void export_model(const ExportOptions& options) {
  const ReleasedCheckpoint checkpoint =
      released_checkpoint(read_safetensors(options.file), options.file.string());
  write_file(options.output, serialize_checkpoint(checkpoint, options.output.stem().string()));
  fmt::print("wrote {}: {} tensors, {} options", options.output.string(),
             checkpoint.state_dict.size(), checkpoint.hparams.size());
  if (!checkpoint.filled.empty()) {
    fmt::print("; {} tensors that inference does not use are zero", checkpoint.filled.size());
  }
  fmt::print("\n");
  if (!checkpoint.differences.empty()) {
    fmt::print(stderr,
               "earpoint: warning: the released class builds a different network and will not load "
               "it: {}\n",
               fmt::join(checkpoint.differences, "; "));
  }
}

/// What `model info` says about a file, of any network.
struct ModelFacts {
  Json description;
  Json training_range;  ///< null of networks that know none
  std::size_t tensors = 0;
  std::int64_t values = 0;
  std::vector<std::string> unused;
};

ModelFacts facts_of(const fs::path& path) {
  SafetensorsFile file = read_safetensors(path);
  const std::string where = path.string();
  ModelFacts facts;
  const NetworkKind kind = network_kind(file, where);
  facts.description = Json::parse(file.metadata.at(std::string(kDescriptionKey)));
  const auto take = [&](auto weights) {
    facts.tensors = weights.tensors.size();
    facts.values = value_count(weights.tensors);
    facts.unused = std::move(weights.unused);
  };
  switch (kind) {
    case NetworkKind::vigas:
      take(vigas_weights(std::move(file), where));
      break;
    case NetworkKind::gtf: {
      GtfWeights weights = gtf_weights(std::move(file), where);
      facts.training_range = Json::parse(to_json(weights.description.training_range));
      take(std::move(weights));
    } break;
    case NetworkKind::rt60_estimator:
      take(rt60_estimator_weights(std::move(file), where));
      break;
    case NetworkKind::vam:
      take(vam_weights(std::move(file), where));
      break;
    case NetworkKind::people:
      take(people_weights(std::move(file), where));
      break;
  }
  return facts;
}

/// A description's value on one line: objects as their values, lists joined.
std::string text_of(const Json& value) {
  if (value.is_null()) return "none";
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_structured()) return value.dump();
  std::vector<std::string> parts;
  for (const auto& [key, item] : value.items()) {
    parts.push_back(value.is_array() ? text_of(item) : fmt::format("{} {}", key, text_of(item)));
  }
  return fmt::format("{}", fmt::join(parts, value.is_array() ? "; " : ", "));
}

/// Writes the file with another training range; every tensor keeps its bytes.
void set_training_range(const RangeOptions& options) {
  const std::string where = options.file.string();
  SafetensorsFile file = read_safetensors(options.file);
  const GtfWeights weights = gtf_weights(file, where);
  const GtfTrainingRange range =
      gtf_training_range_from_json(options.range, "--range", weights.description.training_range);
  file.metadata[std::string(kTrainingRangeKey)] = to_json(range);
  write_safetensors(options.output, file);
  fmt::print("wrote {}: {}\n", options.output.string(), text_of(Json::parse(to_json(range))));
}

void print_info(const InfoOptions& options) {
  const ModelFacts facts = facts_of(options.file);
  if (options.json) {
    Json json{{"file", options.file.string()},
              {"description", facts.description},
              {"tensors", facts.tensors},
              {"values", facts.values},
              {"unused_tensors", facts.unused}};
    if (!facts.training_range.is_null()) json["training_range"] = facts.training_range;
    fmt::print("{}\n", json_text(json));
    return;
  }
  fmt::print("{}\n", options.file.string());
  for (const auto& [key, value] : facts.description.items()) {
    fmt::print("  {:<20} {}\n", key, text_of(value));
  }
  if (!facts.training_range.is_null()) {
    fmt::print("  {:<20} {}\n", "training range", text_of(facts.training_range));
  }
  fmt::print("  {:<20} {}\n  {:<20} {}\n  {:<20} {}\n", "tensors", facts.tensors, "values",
             facts.values, "unused tensors", facts.unused.size());
}

void add_import(CLI::App& model) {
  auto options = std::make_shared<ImportArguments>();
  CLI::App* command = model.add_subcommand(
      "import", "Convert a PyTorch checkpoint of the released code into a weight file.");
  command->add_option("checkpoint", options->checkpoint, "Checkpoint, e.g. best_val.ckpt")
      ->required();
  command->add_option("-o,--output", options->output, "Weight file to write (.safetensors)")
      ->required();
  command->add_flag("--keep-all", options->keep_all,
                    "Keep the tensors that inference does not use, too");
  command->callback([options] { import_model(*options); });
}

void add_export(CLI::App& model) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command = model.add_subcommand(
      "export",
      "Convert a ViGAS weight file into a PyTorch checkpoint that the released code loads.");
  command->add_option("file", options->file, "Weight file (.safetensors)")->required();
  command->add_option("-o,--output", options->output, "Checkpoint to write, e.g. best_val.ckpt")
      ->required();
  command->callback([options] { export_model(*options); });
}

void add_set_range(CLI::App& model) {
  auto options = std::make_shared<RangeOptions>();
  CLI::App* command = model.add_subcommand("set-range",
                                           "Set the training range of a gtf weight file: the moves "
                                           "and speaker positions of its training data.");
  command->add_option("file", options->file, "Weight file (.safetensors)")->required();
  command
      ->add_option("--range", options->range,
                   R"(JSON, e.g. {"farthest_move_m": 5}; missing keys keep their values)")
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "Weight file to write")->required();
  command->callback([options] { set_training_range(*options); });
}

void add_info(CLI::App& model) {
  auto options = std::make_shared<InfoOptions>();
  CLI::App* command = model.add_subcommand("info", "Check a weight file and describe its network.");
  command->add_option("file", options->file, "Weight file (.safetensors)")->required();
  command->add_flag("--json", options->json, "Print JSON");
  command->callback([options] { print_info(*options); });
}

}  // namespace

void add_model_command(CLI::App& app) {
  CLI::App* model = app.add_subcommand("model", "Networks: import, export, inspect, run.");
  model->require_subcommand(1);
  add_export(*model);
  add_import(*model);
  add_info(*model);
  add_set_range(*model);
  add_model_run_command(*model);
}

}  // namespace earpoint
