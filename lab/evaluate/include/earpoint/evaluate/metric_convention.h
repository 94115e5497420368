#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/waveform.h>

namespace earpoint {

/// Whose definitions error metrics follow; docs/metrics.md compares them.
enum class MetricConvention {
  paper,  ///< Chen et al., Novel-View Acoustic Synthesis (CVPR 2023): binaural_metrics()
  rwavs,  ///< Liang et al., AV-NeRF (NeurIPS 2023): rwavs_metrics()
  raf,    ///< Chen et al., Real Acoustic Fields (CVPR 2024): raf_metrics()
  naf,    ///< Luo et al., Learning Neural Acoustic Fields (NeurIPS 2022): naf_metrics()
  avr,    ///< Lan et al., Acoustic Volume Rendering (NeurIPS 2024): avr_metrics()
  iso,    ///< ISO 3382-1:2009: iso_metrics()
};

/// The names of all conventions, as above.
[[nodiscard]] std::vector<std::string> convention_names();
/// Of these, the conventions for impulse responses.
[[nodiscard]] std::vector<std::string> response_convention_names();

/// @param name  one of convention_names()
/// @throws InputError naming convention if it is none of them
[[nodiscard]] MetricConvention convention_named(std::string_view name);

/// Whether a convention compares impulse responses; the others compare binaural sounds.
[[nodiscard]] bool compares_responses(MetricConvention convention);

/// The seconds from the beginning that a convention's published evaluation compares; nothing: all.
[[nodiscard]] std::optional<double> compared_length_s(MetricConvention convention);

/// The rate that a convention of impulse responses works at, for files of `file_rate_hz`:
/// 22,050 Hz for naf, 16 or 48 kHz for raf, the files' own for the others.
[[nodiscard]] int convention_rate_hz(MetricConvention convention, int file_rate_hz);

/// Two impulse responses that metrics can compare sample by sample.
struct ResponsePair {
  Waveform reference;  ///< shape [channels][samples]
  Waveform estimate;   ///< the same shape and rate
};

/// Cuts two impulse responses to the first `length_s` seconds. If one is then shorter, zeros follow
/// it: it has ended.
/// @param length_s  > 0; nothing: the whole of the longer one
/// @param reference_name, estimate_name  stand for the two in messages, e.g. their files
/// @throws InputError if the numbers of channels or the rates differ, one holds no samples or a
///         sample that is not finite, or the reference does not decay, so that it is no impulse
///         response: see check_decays()
[[nodiscard]] ResponsePair response_pair(Waveform reference, std::string_view reference_name,
                                         Waveform estimate, std::string_view estimate_name,
                                         std::optional<double> length_s);

/// Refuses sounds that cannot be impulse responses: in every channel the last quarter after the
/// loudest sample must be at least 3 dB below the first quarter. Responses of 0.1 s with a
/// reverberation time of up to 1.5 s are; continuous speech or noise is not.
/// @throws InputError naming the sound and the channel
void check_decays(const Waveform& sound, std::string_view name);

}  // namespace earpoint
