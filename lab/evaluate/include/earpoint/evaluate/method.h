#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <earpoint/dataset/pair_sample.h>
#include <earpoint/render/make_synthesizer.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// What a method is asked.
struct Question {
  const PairSample& sample;          ///< its target is empty, unless an oracle is asked
  std::string_view scene;            ///< where it is, for methods that have been there before
  const PairTruth* truth = nullptr;  ///< for oracles alone, of simulated data
};

/// A method that renders the sound at the target. One object per thread.
class Method {
 public:
  virtual ~Method() = default;

  /// @return 2 ears, as long as the source, its context included
  /// @throws InputError if the question lacks what the method needs
  [[nodiscard]] virtual Waveform render(const Question& question) = 0;
};

/// A row of the table.
struct MethodEntry {
  std::string name;        ///< "dsp", "vigas", ...
  std::string what;        ///< for people: the weight file, or a few words
  bool is_oracle = false;  ///< it is shown what it should find out
  std::function<std::unique_ptr<Method>()> make;
  bool needs_speaker = false;  ///< it must be told where the speaker stands
  /// Whether the released evaluation would fix its sign by the target, as it does with all that is
  /// synthesized: the source's sound as it is never passes there.
  bool fixes_sign = true;
  bool needs_truth = false;    ///< it must be shown what only a simulator knows
  bool hears_context = false;  ///< of a source with context (PairSample) it takes the whole
};

/// Asks the method about a sample, and shows it what it may see: the target and the truth only if
/// it is an oracle, and never the clean source.
/// @param truth  null where it is not known
/// @return 2 ears, the window that the target is of
[[nodiscard]] Waveform ask(Method& method, const MethodEntry& entry, const PairSample& sample,
                           std::string_view scene, const PairTruth* truth);

/// The paper's first baseline: the target hears what the source heard.
[[nodiscard]] MethodEntry input_method();

/// The paper's signal processing as `earpoint render --model dsp` does it (DspSynthesizer), told
/// where the speaker truly is.
/// @throws InputError if the head-related responses are not there
[[nodiscard]] MethodEntry dsp_method();

/// A network as `earpoint render` runs it (render_in_memory()), on the sound of the sample: windows
/// from its first sample on, cross-faded where it takes several, nothing before and after. A second
/// of sound is one window of networks of a second, and nothing is cross-faded. The ambient sound is
/// separated before, for all methods alike, and peaks are not limited. It sees the picture and the
/// box, and is not told where the speaker stands. A speaker out of sight has a box of four zeros,
/// as in training. A network that was trained on sounds with their ambient part hears it, where the
/// sample has one (PairSample::ambient), and the ambient part is then taken out of what it answers.
/// @param name     of the row
/// @param weights  a file that make_synthesizer() knows; it is read here, before any work is done,
///                 so that a bad one is found
/// @param options  of the network: its texture, whether it was trained for enhancement
/// @throws InputError as make_synthesizer, or if the network wants another rate
[[nodiscard]] MethodEntry network_method(const std::string& name, const std::string& weights,
                                         const SynthesizerOptions& options = {});

}  // namespace earpoint
