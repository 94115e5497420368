#include "axis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/plot/plot.h>

namespace earpoint {
namespace {

Waveform noise(std::ptrdiff_t samples, int rate) {
  RandomStream random(4);
  Waveform sound(2, samples, rate);
  for (float& sample : sound.planar()) sample = static_cast<float>(random.uniform(-0.9, 0.9));
  return sound;
}

/// Sound at a steady level from `begin` to `end`, fractions of one second.
Waveform burst(double begin, double end, float left, float right) {
  Waveform sound(2, 16000, 16000);
  for (int ear = 0; ear < 2; ++ear) {
    for (auto i = static_cast<std::size_t>(16000 * begin);
         i < static_cast<std::size_t>(16000 * end); ++i) {
      sound.channel(ear)[i] = (i % 2 == 0 ? 1.0F : -1.0F) * (ear == 0 ? left : right);
    }
  }
  return sound;
}

TEST(WaveformOutline, LevelsAreThoseOfTheWholeSound) {
  Waveform sound(2, 48000, 48000);
  for (std::size_t i = 0; i < 48000; ++i) {
    const auto phase = static_cast<float>(2.0 * std::numbers::pi * static_cast<double>(i) / 48.0);
    sound.channel(0)[i] = std::sin(phase);
    sound.channel(1)[i] = 0.1F * std::sin(phase);
  }
  const WaveformOutline outline(sound);
  EXPECT_NEAR(outline.level_db(0), -3.0103, 1e-4);  // a sine's mean square is one half; rounded
  EXPECT_NEAR(outline.level_db(1), -23.0103, 1e-4);
  EXPECT_NEAR(outline.peak(), 1.0, 1e-6);
  EXPECT_DOUBLE_EQ(outline.duration_s(), 1.0);
}

TEST(WaveformOutline, SilenceHasNoLevelAndOddSamplesCountAsZero) {
  const WaveformOutline silence(Waveform(2, 100, 16000));
  EXPECT_EQ(silence.level_db(0), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(silence.peak(), 0.0);
  EXPECT_EQ(WaveformOutline(16000).level_db(1), -std::numeric_limits<double>::infinity());
  Waveform odd(2, 3, 16000);
  odd.channel(0)[0] = std::numeric_limits<float>::quiet_NaN();
  odd.channel(0)[1] = std::numeric_limits<float>::infinity();
  odd.channel(0)[2] = 0.5F;
  EXPECT_DOUBLE_EQ(WaveformOutline(odd).peak(), 0.5);
}

TEST(WaveformOutline, KeepsExtremesAndEnergyInBoundedMemoryHoweverFed) {
  const Waveform sound = noise(100'003, 16000);
  const WaveformOutline whole(sound);
  EXPECT_LE(whole.spans(0).size(), 8192U);
  EXPECT_GT(whole.spans(0).size(), 4096U);

  WaveformOutline parts(16000);
  for (std::ptrdiff_t begin = 0; begin < sound.samples(); begin += 977) {
    const auto count = std::min<std::ptrdiff_t>(977, sound.samples() - begin);
    Waveform part(2, count, 16000);
    for (int ear = 0; ear < 2; ++ear) {
      const auto from = sound.channel(ear).subspan(static_cast<std::size_t>(begin),
                                                   static_cast<std::size_t>(count));
      std::copy(from.begin(), from.end(), part.channel(ear).begin());
    }
    parts.add(part);
  }
  ASSERT_EQ(parts.spans(1).size(), whole.spans(1).size());
  const std::int64_t step = whole.samples_per_span();
  for (std::size_t i = 0; i < whole.spans(1).size(); ++i) {
    float low = 1.0F;
    float high = -1.0F;
    double energy = 0.0;
    for (auto k = static_cast<std::int64_t>(i) * step;
         k < std::min((static_cast<std::int64_t>(i) + 1) * step, std::int64_t{sound.samples()});
         ++k) {
      const float sample = sound.channel(1)[static_cast<std::size_t>(k)];
      low = std::min(low, sample);
      high = std::max(high, sample);
      energy += double{sample} * sample;
    }
    for (const WaveformOutline* outline : std::array<const WaveformOutline*, 2>{&whole, &parts}) {
      ASSERT_EQ(outline->spans(1)[i].low, low);
      ASSERT_EQ(outline->spans(1)[i].high, high);
      ASSERT_NEAR(outline->spans(1)[i].energy, energy, 1e-9);  // order of summation
    }
  }
}

/// Whether a region has pixels that are more blue (or more orange) than grey.
int coloured(const Image& image, int x_begin, int x_end, bool blue) {
  int count = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = x_begin; x < x_end; ++x) {
      const int excess = image.at(x, y, 2) - image.at(x, y, 0);
      count += (blue ? excess : -excess) > 60 ? 1 : 0;
    }
  }
  return count;
}

TEST(PlotWaveforms, ShowsEachEarWhereAndAsLoudAsItIs) {
  // Left in the first half, right, at half the amplitude, in the second.
  Waveform sound = burst(0.1, 0.4, 0.75F, 0.0F);
  const Waveform other = burst(0.6, 0.9, 0.0F, 0.375F);
  for (std::size_t i = 0; i < sound.planar().size(); ++i) sound.planar()[i] += other.planar()[i];
  const std::vector<WaveformPanel> panels = {{"x", WaveformOutline(sound)}};
  const Image image = plot_waveforms(panels, "", 1000);
  ASSERT_EQ(image.width(), 1000);
  // From 0.2 to 0.3 s and from 0.7 to 0.8 s of the plot's 916 columns; a thin line is in all
  // columns.
  const int blue_loud = coloured(image, 64 + 190, 64 + 270, true);
  const int blue_quiet = coloured(image, 64 + 650, 64 + 730, true);
  const int orange_loud = coloured(image, 64 + 650, 64 + 730, false);
  const int orange_quiet = coloured(image, 64 + 190, 64 + 270, false);
  EXPECT_GT(blue_loud, 80 * 50) << "the lane of 62 rows ends at 0.8";
  EXPECT_LE(blue_quiet, 80 * 2);
  // Rows at the ends are partly covered.
  EXPECT_NEAR(orange_loud, 0.5 * blue_loud, 0.1 * blue_loud);
  EXPECT_LE(orange_quiet, 80 * 2);
}

TEST(PlotWaveforms, AllPanelsShareOneScaleAndOneTimeAxis) {
  const std::vector<WaveformPanel> both = {{"loud", WaveformOutline(burst(0.0, 1.0, 0.8F, 0.8F))},
                                           {"soft", WaveformOutline(burst(0.0, 0.5, 0.2F, 0.2F))}};
  const Image one = plot_waveforms(std::span(both).first(1), "title", 800);
  const Image two = plot_waveforms(both, "title", 800);
  const int panel_height = two.height() - one.height();
  EXPECT_GT(panel_height, 100);
  // The second panel's levels and waveform, over its own columns: a quarter as high, half as long.
  const auto count_in = [&](int y_begin, int y_end, int x) {
    int count = 0;
    for (int y = y_begin; y < y_end; ++y) count += two.at(x, y, 2) - two.at(x, y, 0) > 60 ? 1 : 0;
    return count;
  };
  const int first_top = 16 + 28 + 26;
  const int loud = count_in(first_top, first_top + 62, 300);
  const int soft = count_in(first_top + panel_height, first_top + panel_height + 62, 300);
  // A row at either end, and the least height of a waveform, one line.
  EXPECT_NEAR(soft, 0.25 * loud, 3);
  EXPECT_LE(count_in(first_top + panel_height, first_top + panel_height + 62, 700), 2) << "a line";
}

TEST(PlotWaveforms, EmptySoundStillGivesAPlot) {
  const std::vector<WaveformPanel> panels = {{"nothing", WaveformOutline(16000)}};
  EXPECT_GT(plot_waveforms(panels, "", 400).height(), 100);
  EXPECT_THROW((void)plot_waveforms({}, "", 800), std::logic_error);
}

TEST(PlotSpectrograms, APeakStandsAtItsTimeAndFrequency) {
  constexpr int kFrames = 100;
  constexpr int kBins = 257;
  std::vector<float> levels(static_cast<std::size_t>(kFrames) * kBins,
                            -std::numeric_limits<float>::infinity());
  // Frame 25 of 100 and bin 193 of 257: at a quarter of the width and three quarters of the height.
  levels[25 * kBins + 193] = -12.0F;
  levels[3] = std::numeric_limits<float>::quiet_NaN();
  const std::vector<SpectrogramPanel> panels = {{"x", levels, kFrames, kBins, 1.0, 8000.0}};
  EXPECT_EQ(top_level_db(panels), -10.0);
  const Image image = plot_spectrograms(panels, "", -12.0, 60.0, 1000);
  // The map's 200 rows begin below the header; its columns end before the scale.
  const int left = 52;
  const int right = 1000 - 76;
  const int top = 10 + 26;
  double x_sum = 0.0;
  double y_sum = 0.0;
  int count = 0;
  for (int y = top; y < top + 200; ++y) {
    for (int x = left; x < right; ++x) {
      if (image.at(x, y, 0) < 200) continue;
      x_sum += x;
      y_sum += y;
      ++count;
    }
  }
  ASSERT_GT(count, 0);
  // A frame is a hundredth of the width, with the peak in its middle; a bin is less than one of 200
  // rows.
  EXPECT_NEAR((x_sum / count - left) / (right - left), 0.255, 0.01);
  EXPECT_NEAR((y_sum / count - top) / 200.0, 0.25, 0.01);
}

TEST(PlotSpectrograms, LouderIsBrighter) {
  std::vector<float> levels(60);
  for (std::size_t i = 0; i < 60; ++i) levels[i] = static_cast<float>(i) - 59.0F;  // one bin
  const std::vector<SpectrogramPanel> panels = {{"", levels, 60, 1, 1.0, 100.0}};
  const Image image = plot_spectrograms(panels, "", 0.0, 60.0, 800);
  double before = -1.0;
  for (int x = 52 + 5; x < 800 - 76; x += 12) {
    const double lightness =
        0.2126 * image.at(x, 100, 0) + 0.7152 * image.at(x, 100, 1) + 0.0722 * image.at(x, 100, 2);
    EXPECT_GT(lightness, before) << x;
    before = lightness;
  }
}

TEST(PlotSpectrograms, WrongShapesAreTheCallersBug) {
  const std::vector<float> levels(10);
  std::vector<SpectrogramPanel> panels = {{"", levels, 3, 4, 1.0, 100.0}};
  EXPECT_THROW((void)plot_spectrograms(panels, "", 0.0), std::logic_error);
  panels[0] = {"", levels, 5, 2, 0.0, 100.0};
  EXPECT_THROW((void)plot_spectrograms(panels, "", 0.0), std::logic_error);
}

TEST(Ticks, AreRoundWithinTheRangeAndNotTooMany) {
  const auto texts = [](double low, double high, int most) {
    std::vector<std::string> result;
    for (const Tick& tick : ticks(low, high, most)) result.push_back(tick.text);
    return result;
  };
  EXPECT_EQ(texts(0.0, 8.0, 10),
            (std::vector<std::string>{"0", "1", "2", "3", "4", "5", "6", "7", "8"}));
  EXPECT_EQ(texts(0.0, 0.02, 6),
            (std::vector<std::string>{"0.000", "0.005", "0.010", "0.015", "0.020"}));
  EXPECT_EQ(texts(-55.0, 25.0, 6), (std::vector<std::string>{"-40", "-20", "0", "20"}));
  EXPECT_EQ(texts(0.0, 600.0, 5), (std::vector<std::string>{"0", "200", "400", "600"}));
  EXPECT_EQ(texts(0.0, 1.0, 3), (std::vector<std::string>{"0.0", "0.5", "1.0"}));
}

}  // namespace
}  // namespace earpoint
