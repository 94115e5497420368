// Compares this module with what the released evaluation computes from the same inputs.
// testdata/ holds a part of the reference data; the whole is read where EARPOINT_ORACLE_DIR says.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/butterworth.h>
#include <earpoint/audio/gcc_phat.h>
#include <earpoint/audio/resample.h>
#include <earpoint/audio/stft.h>
#include <earpoint/weights/safetensors.h>
#include <earpoint/weights_testing/reference_folders.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// The folders with reference data: testdata, and the whole set if it is there.
std::vector<fs::path> folders() { return reference_folders("src/audio/testdata", "D_signal"); }

std::vector<SafetensorsFile> files(const std::string& name) {
  std::vector<SafetensorsFile> result;
  for (const fs::path& folder : folders()) result.push_back(read_safetensors(folder / name));
  return result;
}

/// Row `row` of a tensor of two axes; the whole of a tensor of one.
template <typename T>
std::span<const T> row_of(const Tensor& tensor, std::int64_t row) {
  const auto length = static_cast<std::size_t>(tensor.shape.back());
  return tensor.as<T>().subspan(static_cast<std::size_t>(row) * length, length);
}

TEST(ButterworthOracle, SectionsAreTheReferences) {
  for (const SafetensorsFile& file : files("filter.safetensors")) {
    for (const auto& [name, cut_hz] : {std::pair{"sos_80", 80.0}, {"sos_150", 150.0}}) {
      const auto sections = butterworth_bandpass(cut_hz, 7999.0, 16000.0);
      const std::span<const double> expected = file.tensors.at(name).as<double>();
      ASSERT_EQ(sections.size() * 6, expected.size());
      for (std::size_t i = 0; i < sections.size(); ++i) {
        const SecondOrderSection& s = sections[i];
        const double found[6] = {s.b0, s.b1, s.b2, 1.0, s.a1, s.a2};
        for (int j = 0; j < 6; ++j) {
          // Poles within 1e-4 of the unit circle magnify the rounding of the tangents.
          EXPECT_NEAR(found[j], expected[6 * i + j], 1e-12) << name << " section " << i;
        }
      }
    }
  }
}

TEST(ButterworthOracle, ZeroPhaseFilteringIsTheReferences) {
  for (const SafetensorsFile& file : files("filter.safetensors")) {
    for (const auto& [suffix, cut_hz] : {std::pair{"_cut80", 80.0}, {"_cut150", 150.0}}) {
      const auto sections = butterworth_bandpass(cut_hz, 7999.0, 16000.0);
      for (const std::string name : {"x1", "x2"}) {
        if (!file.tensors.contains(name)) continue;
        const Tensor& input = file.tensors.at(name);
        const std::int64_t rows = input.elements() / input.shape.back();
        for (std::int64_t row = 0; row < rows; ++row) {
          const std::span<const double> in = row_of<double>(input, row);
          const std::span<const double> expected =
              row_of<double>(file.tensors.at(name + suffix), row);
          std::vector<double> out(in.size());
          filter_zero_phase(sections, in, out);
          for (std::size_t n = 0; n < out.size(); ++n) {
            ASSERT_NEAR(out[n], expected[n], 1e-11) << name << suffix << " sample " << n;
          }
        }
      }
    }
  }
}

TEST(GccPhatOracle, DelaysAreTheReferencesToTheSixteenthOfASample) {
  for (const SafetensorsFile& file : files("gcc_phat.safetensors")) {
    const std::span<const double> expected = file.tensors.at("delay").as<double>();
    const std::span<const double> margin = file.tensors.at("margin").as<double>();
    for (std::size_t pair = 0; pair < expected.size(); ++pair) {
      // Two independent noises have several peaks of nearly equal height; those pairs are skipped.
      if (margin[pair] < 1e-4) continue;
      EXPECT_EQ(gcc_phat_delay_samples(row_of<float>(file.tensors.at("sig"), pair),
                                       row_of<float>(file.tensors.at("ref"), pair)),
                expected[pair])
          << "pair " << pair;
    }
  }
}

TEST(GccPhatOracle, SilenceGivesTheReferencesEdge) {
  for (const SafetensorsFile& file : files("gcc_phat.safetensors")) {
    const std::span<const float> reference = row_of<float>(file.tensors.at("ref"), 0);
    const std::vector<float> silence(reference.size());
    const std::span<const double> expected = file.tensors.at("edge").as<double>();
    EXPECT_EQ(gcc_phat_delay_samples(silence, reference), expected[0]);
    EXPECT_EQ(gcc_phat_delay_samples(reference, silence), expected[1]);
    EXPECT_EQ(gcc_phat_delay_samples(reference, reference), expected[2]);
  }
}

TEST(ResampleOracle, SincFollowsTheReference) {
  for (const SafetensorsFile& file : files("resample.safetensors")) {
    for (const int rate_hz : {48000, 44100, 22050, 8000}) {
      const Tensor& input = file.tensors.at("in_" + std::to_string(rate_hz));
      const Tensor& expected = file.tensors.at("out_" + std::to_string(rate_hz));
      const auto channels = static_cast<int>(input.shape[0]);
      Waveform wave(channels, input.shape[1], rate_hz);
      std::ranges::copy(input.as<float>(), wave.planar().begin());
      const Waveform out = resample_sinc(wave, 16000);
      ASSERT_EQ(out.samples(), expected.shape[1]);
      for (std::size_t i = 0; i < out.planar().size(); ++i) {
        // The reference rounds its taps to float.
        ASSERT_NEAR(out.planar()[i], expected.as<float>()[i], 3e-6F) << rate_hz << " Hz at " << i;
      }
    }
  }
}

/// @param sound     [channels][samples]
/// @param expected  [channels][bins][frames][real and imaginary part]
void expect_transforms(std::span<const float> sound, std::int64_t samples,
                       std::span<const float> expected) {
  Stft stft;
  for (std::size_t c = 0; c < 2; ++c) {
    const Spectrogram found = stft.forward(sound.subspan(c * samples, samples));
    ASSERT_EQ(found.frames, 1 + samples / 160);
    ASSERT_EQ(found.bins, 257);
    ASSERT_EQ(expected.size(), std::size_t{2} * 257 * found.frames * 2);
    for (int frame = 0; frame < found.frames; ++frame) {
      for (int bin = 0; bin < found.bins; ++bin) {
        const std::size_t at = ((c * 257 + bin) * found.frames + frame) * 2;
        // Values of up to 100 in float.
        ASSERT_NEAR(found.frame(frame)[bin].real(), expected[at], 2e-5F);
        ASSERT_NEAR(found.frame(frame)[bin].imag(), expected[at + 1], 2e-5F);
      }
    }
  }
}

TEST(StftOracle, ValuesAreNumpysAndTheReferences) {
  std::vector<fs::path> paths{folders()[0] / "stft.safetensors"};
  if (folders().size() > 1) paths.push_back(folders()[1] / "metrics.safetensors");
  for (const fs::path& path : paths) {
    SCOPED_TRACE(path);
    const SafetensorsFile file = read_safetensors(path);
    const Tensor& sounds = file.tensors.at("tgt");  // of the first pair
    const std::int64_t samples = sounds.shape[2];
    expect_transforms(sounds.as<float>().first(2 * samples), samples,
                      file.tensors.at("stft0").as<float>());
  }
}

}  // namespace
}  // namespace earpoint
