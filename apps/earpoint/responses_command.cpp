#include "responses_command.h"

#include "json_text.h"
#include "response_report.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/resample.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/dataset/raf.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/metric_convention.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kFooter = R"(
Examples:
  earpoint responses --data raf/EmptyRoom --limit 5
  earpoint responses --data raf/EmptyRoom --estimates out/rirs --json
  earpoint responses --data raf/EmptyRoom --nearest --limit 500
  earpoint responses --data raf/EmptyRoom --estimates out/rirs --convention iso

--data names one room of Real Acoustic Fields: data/ID/{rir.wav,rx_pos.txt,tx_pos.txt}, and the room's split
list as metadata/data-split.json or by --split-file. Without --estimates and --nearest the items are listed:
the microphone and the loudspeaker in metres, in the frame in which `earpoint trace` reads the room's model, as its
--listener and --source take them. With --estimates ID.wav of that folder is compared with each response of
the split, with --nearest the response of the nearest item of the split train, and the means are printed.
--convention is as in `earpoint metrics` (raf, naf, avr, iso). Of raf and naf a T60 that cannot be measured
counts as 100 %; other missing values are left out of their mean, and counted.
)";

struct Options {
  fs::path data;
  std::string split = "test";
  fs::path split_file;
  fs::path estimates;
  bool nearest = false;
  std::string convention = "raf";
  std::optional<double> length_s;
  std::optional<std::size_t> limit;
  bool json = false;
};

RafDataset dataset_of(const Options& options, const std::string& split) {
  return RafDataset({.folder = options.data, .split = split, .split_file = options.split_file});
}

/// `limit` of the items, spread evenly.
std::vector<RafItem> chosen(const RafDataset& dataset, std::optional<std::size_t> limit) {
  const std::vector<RafItem>& all = dataset.items();
  const std::size_t count = std::min(limit.value_or(all.size()), all.size());
  std::vector<RafItem> items;
  for (std::size_t i = 0; i < count; ++i) items.push_back(all[i * all.size() / count]);
  return items;
}

std::string place(const Vector3& at) {
  return fmt::format("{:.4g},{:.4g},{:.4g}", at.x, at.y, at.z);
}

std::string source_of(const RafItem& item) {
  const double yaw_rad = euler_from_quaternion(item.world_from_speaker.orientation).yaw_rad;
  return fmt::format("{},yaw={:.4g}", place(item.world_from_speaker.position_m),
                     degrees_from_radians(yaw_rad));
}

void list(const Options& options) {
  const RafDataset dataset = dataset_of(options, options.split);
  Json items = Json::array();
  for (const RafItem& item : chosen(dataset, options.limit)) {
    const std::string source = source_of(item);
    const std::string listener = place(item.receiver_m);
    items.push_back({{"id", item.id}, {"source", source}, {"listener", listener}});
    if (!options.json) fmt::print("{}  source {}  listener {}\n", item.id, source, listener);
  }
  if (options.json) fmt::print("{}\n", json_text(Json({{"items", items}})));
}

/// Where estimates come from.
class Estimates {
 public:
  explicit Estimates(const Options& options) : options_(options) {
    if (options.nearest) training_.emplace(dataset_of(options, "train"));
  }
  /// What messages call an estimate, and the estimate.
  [[nodiscard]] std::pair<std::string, Waveform> of(const RafItem& item) const {
    if (training_) {
      const RafItem& nearest = nearest_item(item, training_->items());
      return {nearest.id, training_->response(nearest)};
    }
    const fs::path file = options_.estimates / (item.id + ".wav");
    return {file.string(), read_sound(stored_input(file))};
  }

 private:
  const Options& options_;
  std::optional<RafDataset> training_;
};

/// Sums of the rows of many reports.
class Means {
 public:
  void add(const MetricsReport& report) {
    if (rows_.empty()) rows_ = std::vector<Sum>(report.rows.size());
    for (std::size_t i = 0; i < report.rows.size(); ++i) {
      rows_[i].key = report.rows[i].key;
      rows_[i].unit = report.rows[i].unit;
      if (report.rows[i].value.is_null()) continue;
      rows_[i].sum += report.rows[i].value.get<double>();
      ++rows_[i].count;
    }
    ++items_;
    const auto invalid = report.extra.find("t60_invalid");
    if (invalid != report.extra.end() && invalid->get<bool>()) ++invalid_;
  }
  [[nodiscard]] MetricsReport report() const {
    MetricsReport result;
    for (const Sum& row : rows_) {
      result.rows.push_back(
          {row.key, row.count > 0 ? Json(row.sum / row.count) : Json(nullptr), row.unit});
      if (row.count < items_) {
        result.notes.push_back(
            fmt::format("{} has no value for {} of {} items", row.key, items_ - row.count, items_));
      }
    }
    if (invalid_ > 0) {
      result.notes.push_back(
          fmt::format("{} of {} items have no T60 and count as 100 %", invalid_, items_));
    }
    result.extra["items"] = items_;
    result.extra["t60_invalid"] = invalid_;
    return result;
  }

 private:
  struct Sum {
    std::string key;
    std::string unit;
    double sum = 0.0;
    int count = 0;
  };
  std::vector<Sum> rows_;
  int items_ = 0;
  int invalid_ = 0;
};

void compare(const Options& options) {
  const MetricConvention convention = convention_named(options.convention);
  const RafDataset dataset = dataset_of(options, options.split);
  const Estimates estimates(options);
  const std::optional<double> length_s =
      options.length_s ? options.length_s : compared_length_s(convention);
  Means means;
  for (const RafItem& item : chosen(dataset, options.limit)) {
    Waveform reference = dataset.response(item);
    auto [name, estimate] = estimates.of(item);
    const int rate_hz = convention_rate_hz(convention, reference.sample_rate_hz());
    means.add(
        response_report(convention, response_pair(resample(reference, rate_hz), item.id,
                                                  resample(estimate, rate_hz), name, length_s)));
  }
  MetricsReport report = means.report();
  report.extra["convention"] = options.convention;
  report.extra["split"] = options.split;
  print_report(report, options.json);
}

void run(const Options& options) {
  if (options.nearest && !options.estimates.empty()) {
    throw InputError("--nearest", "cannot be combined with --estimates", "leave out one of them");
  }
  if (options.nearest || !options.estimates.empty()) return compare(options);
  list(options);
}

}  // namespace

void add_responses_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "responses", "List the impulse responses of Real Acoustic Fields, or compare estimates.");
  command->add_option("--data", options->data, "Folder of a room, e.g. EmptyRoom")->required();
  command->add_option("--split", options->split, "Split of the items; all needs no list")
      ->check(CLI::IsMember({"train", "validation", "test", "all"}))
      ->capture_default_str();
  command->add_option("--split-file", options->split_file,
                      "The room's published list (default: metadata/data-split.json)");
  command->add_option("--estimates", options->estimates,
                      "Folder of estimated responses, ID.wav, to compare");
  command->add_flag("--nearest", options->nearest,
                    "Compare the response of the nearest item of the split train");
  command->add_option("--convention", options->convention, "Definitions of the metrics")
      ->check(CLI::IsMember(response_convention_names()))
      ->capture_default_str();
  command
      ->add_option("--length", options->length_s,
                   "Seconds to compare, from the first sample (default: 0.32 for raf, 0.1 for "
                   "avr, else all)")
      ->check(CLI::PositiveNumber);
  command->add_option("--limit", options->limit, "Only so many items, spread over the split")
      ->check(CLI::PositiveNumber);
  command->add_flag("--json", options->json, "Print JSON");
  command->footer(kFooter);
  command->callback([options] { run(*options); });
}

}  // namespace earpoint
