#include "metrics_command.h"

#include "metrics_report.h"
#include "response_report.h"
#include "rt60_model.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/sound_file.h>
#include <earpoint/audio/window_of.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/decay_metrics.h>
#include <earpoint/evaluate/metric_convention.h>
#include <earpoint/evaluate/metrics.h>
#include <earpoint/evaluate/reverberation_error.h>
#include <earpoint/evaluate/speech_metrics.h>
#include <earpoint/rt60/weights.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct MetricsOptions {
  fs::path reference;
  fs::path estimate;
  std::string convention = "paper";
  std::optional<double> length_s;
  std::string variant = "vigas";
  fs::path rt60_model;
  bool impulse_responses = false;
  bool trim = false;
  bool sign_fix = false;
  bool json = false;
};

constexpr const char* kExamples = R"(
Examples:
  earpoint metrics there.wav rendered.wav
  earpoint metrics there.wav rendered.wav --json
  earpoint metrics there.wav rendered.wav --variant rwavs
  earpoint metrics near.wav dry.wav --variant speech
  earpoint metrics measured_brir.wav traced_brir.wav --impulse-responses
  earpoint metrics measured_rir.wav traced_rir.wav --convention raf --json

Zero is best, except for speech. Both sounds are binaural (left, right) and of equal length.
  mag             sum over the ears of the mean difference of STFT magnitudes
  lre_db          difference of the left-right energy ratios, dB; none if a left ear is silent
  stft_distance   sum over the ears of the Euclidean distance of the STFTs
  l2              mean squared difference of the samples
  rte_s           mean difference of the ears' T60, estimated from the sounds by a network; none
                  if models/rt60.safetensors is missing
  delay_samples   mean delay of the ears at 16 kHz, at most 50 (also for a silent ear)
--variant rwavs:
  mag             sum over the ears of the mean squared difference of STFT magnitudes, 22.05 kHz
  env             sum over the ears of the RMS difference of the Hilbert envelopes
--variant speech (any number of channels, means over them; more is better):
  si_sdr_db       scale-invariant signal-to-distortion ratio, 16 kHz; none for silence
  estoi           extended short-time objective intelligibility, at most 1; none for less than
                  0.4 s of speech
--impulse-responses (any number of channels; means of absolute differences):
  t60_error_s, t60_error_percent, edt_error_s, c50_error_db
--convention: the definitions of other papers and of a standard, as their released code computes them.
Binaural sounds:
  paper           the default above
  rwavs           AV-NeRF on RWAVS; the same as --variant rwavs
Impulse responses, of any number of channels; a reference that does not decay is refused:
  raf             Real Acoustic Fields, 48 kHz (or 16): stft_error, t60_error_percent after a high-pass at
                  200 Hz from -5 to -15 dB, edt_error_s, c50_error_db
  naf             Neural Acoustic Fields, 22.05 kHz: spectral_loss, t60_error_percent from -5 to -35 dB
  avr             Acoustic Volume Rendering, the rate of both files: phase, amp, env, t60_error_percent from -5 to
                  -25 dB, edt_error_s, c50_error_db, multi_stft
  iso             ISO 3382-1, the rate of both files: edt, t20 and t30_error_percent, c50 and c80_error_db, d50_error,
                  ts_error_ms, means of the octaves at 500 Hz and 1 kHz; --json has 125 Hz to 4 kHz
A T60 that cannot be measured counts as 100 % by raf and naf, as in their code, and is noted. docs/metrics.md
has the differences and what each leaves out.
)";

using Report = MetricsReport;

void trim_to(Waveform& wave, std::ptrdiff_t samples) {
  if (wave.samples() > samples) wave = window_of(wave, 0, samples);
}

/// Both sounds, comparable.
struct Pair {
  Waveform reference;
  Waveform estimate;
};

/// Refuses channels that do not correspond, and samples that are no numbers.
void check_speech(const Pair& pair, const MetricsOptions& options) {
  if (pair.reference.channels() != pair.estimate.channels()) {
    throw InputError(options.estimate.string(),
                     fmt::format("has {} channels, {} has {}", pair.estimate.channels(),
                                 options.reference.string(), pair.reference.channels()),
                     "compare sounds with the same number of channels");
  }
  for (const auto& [sound, path] : {std::pair{&pair.reference, &options.reference},
                                    std::pair{&pair.estimate, &options.estimate}}) {
    if (!std::ranges::all_of(sound->planar(), [](float x) { return std::isfinite(x); })) {
      throw InputError(path->string(), "contains NaN or infinite samples", "write the file again");
    }
  }
}

Pair read_pair(const MetricsOptions& options, Report& report) {
  Pair pair{read_sound(stored_input(options.reference)),
            read_sound(stored_input(options.estimate))};
  const int rate_hz = options.variant == "rwavs" ? kRwavsRateHz : kMetricRateHz;
  to_rate(pair.reference, rate_hz, options.reference, report);
  to_rate(pair.estimate, rate_hz, options.estimate, report);
  const std::ptrdiff_t shorter = std::min(pair.reference.samples(), pair.estimate.samples());
  const std::ptrdiff_t longer = std::max(pair.reference.samples(), pair.estimate.samples());
  if (shorter != longer) {
    if (!options.trim) {
      throw InputError(options.estimate.string(),
                       fmt::format("has {} samples, {} has {}", pair.estimate.samples(),
                                   options.reference.string(), pair.reference.samples()),
                       "use --trim to compare the common length");
    }
    report.notes.push_back(fmt::format("{} samples at the end left out", longer - shorter));
    trim_to(pair.reference, shorter);
    trim_to(pair.estimate, shorter);
  }
  if (options.variant == "speech") {
    check_speech(pair, options);
  } else {
    check_comparable(pair.reference, options.reference.string(), pair.estimate,
                     options.estimate.string());
  }
  return pair;
}

/// Speech may have any number of channels.
Report compare_speech(const MetricsOptions& options) {
  Report report;
  const Pair pair = read_pair(options, report);
  const int channels = pair.reference.channels();
  Estoi estoi;
  std::optional<double> ratio = 0.0;
  std::optional<double> intelligible = 0.0;
  const auto add = [channels](std::optional<double>& sum, const std::optional<double>& value) {
    sum = sum && value ? std::optional(*sum + *value / channels) : std::nullopt;
  };
  for (int c = 0; c < channels; ++c) {
    const auto reference = pair.reference.channel(c);
    const auto estimate = pair.estimate.channel(c);
    add(ratio, si_sdr_db(reference, estimate));
    add(intelligible, estoi.measure(reference, estimate, kMetricRateHz));
  }
  const auto json = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  report.rows = {{"si_sdr_db", json(ratio), "dB"}, {"estoi", json(intelligible), ""}};
  report.extra["samples"] = pair.reference.samples();
  report.extra["sample_rate_hz"] = pair.reference.sample_rate_hz();
  return report;
}

/// Adds RTE, if there is an estimator for it.
void add_reverberation_error(const MetricsOptions& options, const Pair& pair, Report& report) {
  const std::optional<fs::path> model = rt60_model(options.rt60_model);
  if (!model) {
    report.notes.emplace_back(kNoRt60Model);
    report.rows.push_back({"rte_s", Json(nullptr), "s"});
    return;
  }
  Rt60Estimator estimator(read_rt60_estimator_weights(*model));
  report.rows.push_back(
      {"rte_s", reverberation_error_s(estimator, pair.reference, pair.estimate), "s"});
}

Report compare_sounds(const MetricsOptions& options) {
  Report report;
  Pair pair = read_pair(options, report);
  if (options.sign_fix) {
    const SignFix fix = fix_sign(std::span(&pair.estimate, 1), std::span(&pair.reference, 1));
    report.notes.emplace_back(fix == SignFix::none ? "the sign fix changed nothing"
                              : fix == SignFix::negated_left
                                  ? "the sign fix negated the left ear"
                                  : "the sign fix negated the right ear");
  }
  report.extra["samples"] = pair.reference.samples();
  report.extra["sample_rate_hz"] = pair.reference.sample_rate_hz();
  if (options.variant == "rwavs") {
    const RwavsMetrics m = rwavs_metrics(pair.reference, pair.estimate);
    report.rows = {{"mag", m.mag, ""}, {"env", m.env, ""}};
    return report;
  }
  const BinauralMetrics m = binaural_metrics(pair.reference, pair.estimate);
  if (!m.lre_db) report.notes.emplace_back("a left ear is silent, so lre_db has no value");
  report.rows = {{"mag", m.mag, ""}, {"lre_db", m.lre_db ? Json(*m.lre_db) : Json(nullptr), "dB"}};
  add_reverberation_error(options, pair, report);
  report.rows.insert(report.rows.end(), {{"stft_distance", m.stft_distance, ""},
                                         {"l2", m.l2, ""},
                                         {"delay_samples", m.delay_samples, "samples"}});
  return report;
}

Json json_of(const std::vector<ChannelDecay>& channels) {
  Json list = Json::array();
  for (const ChannelDecay& channel : channels) {
    list.push_back(
        {{"t60_s", channel.t60_s}, {"edt_s", channel.edt_s}, {"c50_db", channel.c50_db}});
  }
  return list;
}

Report compare_impulse_responses(const MetricsOptions& options) {
  const DecayComparison found =
      compare_decays(read_sound(stored_input(options.reference)), options.reference.string(),
                     read_sound(stored_input(options.estimate)), options.estimate.string());
  const bool t30 = found.range == DecayRange::t30;
  Report report;
  report.rows = {{"t60_error_s", found.t60_error_s, "s"},
                 {"t60_error_percent", found.t60_error_percent, "%"},
                 {"edt_error_s", found.edt_error_s, "s"},
                 {"c50_error_db", found.c50_error_db, "dB"}};
  report.notes.emplace_back(t30 ? "T60 is T30, read from -5 to -35 dB"
                                : "T60 is T20, read from -5 to -25 dB: not all decay to -35 dB");
  report.extra["t60_range"] = t30 ? "t30" : "t20";
  report.extra["reference"] = json_of(found.reference);
  report.extra["estimate"] = json_of(found.estimate);
  return report;
}

/// What the convention, or else the variant, asks for.
Report compare(MetricsOptions options) {
  const MetricConvention convention = convention_named(options.convention);
  if (compares_responses(convention)) {
    for (const auto& [given, flag] :
         {std::pair{options.trim, "--trim"}, std::pair{options.sign_fix, "--sign-fix"},
          std::pair{!options.rt60_model.empty(), "--rt60-model"}}) {
      if (given) {
        throw InputError(flag, "applies to binaural sounds, not to impulse responses",
                         "leave it out");
      }
    }
    return response_report(convention, options.reference, options.estimate, options.length_s);
  }
  if (options.length_s) {
    throw InputError("--length", "applies only to conventions for impulse responses",
                     "leave it out, or choose raf, naf, avr or iso");
  }
  if (convention == MetricConvention::rwavs) options.variant = "rwavs";
  if (options.impulse_responses) return compare_impulse_responses(options);
  return options.variant == "speech" ? compare_speech(options) : compare_sounds(options);
}

}  // namespace

void add_metrics_command(CLI::App& app) {
  auto options = std::make_shared<MetricsOptions>();
  CLI::App* command = app.add_subcommand(
      "metrics", "Measure the error of an estimated sound against its reference.");
  command->add_option("reference", options->reference, "The true sound (WAV, FLAC, ...)")
      ->required();
  command->add_option("estimate", options->estimate, "The rendered sound")->required();
  command->add_flag("--json", options->json, "Print JSON");
  auto* variant = command
                      ->add_option("--variant", options->variant,
                                   "Definitions: vigas (16 kHz) or rwavs (22.05 kHz); or "
                                   "speech: SI-SDR and ESTOI")
                      ->check(CLI::IsMember({"vigas", "rwavs", "speech"}))
                      ->capture_default_str();
  auto* decays = command->add_flag("--impulse-responses", options->impulse_responses,
                                   "The sounds are impulse responses: compare T60, EDT and C50");
  decays->excludes(variant);
  auto* convention =
      command
          ->add_option("--convention", options->convention,
                       "Whose definitions: paper or rwavs (binaural sounds); raf, naf, avr or iso "
                       "(impulse responses)")
          ->check(CLI::IsMember(convention_names()))
          ->capture_default_str()
          ->excludes(variant)
          ->excludes(decays);
  command
      ->add_option("--length", options->length_s,
                   "Seconds of impulse responses to compare, from their first sample (default: "
                   "0.32 for raf, 0.1 for avr, else all)")
      ->check(CLI::PositiveNumber)
      ->needs(convention);
  command
      ->add_option("--rt60-model", options->rt60_model,
                   "Weight file of the estimator behind rte_s (default: the shipped one)")
      ->excludes(decays);
  auto* trim = command->add_flag("--trim", options->trim,
                                 "Compare sounds of different lengths over the common length");
  auto* sign_fix = command->add_flag(
      "--sign-fix", options->sign_fix,
      "First negate one ear of an estimate in opposite phase, as the published evaluation does");
  trim->excludes(decays);
  sign_fix->excludes(decays);
  command->footer(kExamples);
  command->callback([options] { print_report(compare(*options), options->json); });
}

}  // namespace earpoint
