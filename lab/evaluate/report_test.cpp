#include "report_figures.h"

#include <algorithm>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/oracles.h>
#include <earpoint/evaluate/report.h>
#include <earpoint/evaluate/report_html.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

std::string base64_of(std::string_view text) {
  return base64(std::as_bytes(std::span(text.data(), text.size())));
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++found;
  }
  return found;
}

TEST(ReportHtml, Base64IsThatOfTheStandard) {
  // RFC 4648, section 10.
  EXPECT_EQ(base64_of(""), "");
  EXPECT_EQ(base64_of("f"), "Zg==");
  EXPECT_EQ(base64_of("fo"), "Zm8=");
  EXPECT_EQ(base64_of("foo"), "Zm9v");
  EXPECT_EQ(base64_of("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64_of("\xFB\xFF"), "+/8=");
}

TEST(ReportHtml, NamesCannotBecomeMarkup) {
  EXPECT_EQ(escaped("a<b> & \"c\""), "a&lt;b&gt; &amp; &quot;c&quot;");
}

TEST(ReportHtml, WavIsReadBack) {
  Waveform sound(2, 5, 16000);
  for (int i = 0; i < 5; ++i) {
    sound.channel(0)[i] = static_cast<float>(0.1 * i);
    sound.channel(1)[i] = static_cast<float>(-0.2 * i);
  }
  const fs::path path =
      fs::path(testing::TempDir()) / ("report." + std::to_string(::getpid()) + ".wav");
  write_file(path, std::string_view(wav_bytes(sound, 2.0F)));
  const Waveform found = read_sound(path);
  fs::remove(path);
  ASSERT_EQ(found.channels(), 2);
  ASSERT_EQ(found.samples(), 5);
  EXPECT_EQ(found.sample_rate_hz(), 16000);
  for (int i = 0; i < 5; ++i) {
    // Half a step of 16 bits. Values above full scale are clamped.
    EXPECT_NEAR(found.channel(0)[i], 0.2 * i, 1.6e-5);
    EXPECT_NEAR(found.channel(1)[i], std::max(-1.0, -0.4 * i), 1.6e-5);
  }
}

TEST(ReportFigures, MapPutsLeftLeftAndAheadUp) {
  // The target stands 2 m ahead and 1 m to the left, the speaker 1 m to the right of the source.
  const std::string svg = map_svg({{2.0, 1.0, 0.0}, {}}, Vector3{0.0, -1.0, 0.0});
  // Two metres across and two up fill 256 pixels less margins of 34: 94 pixels per metre.
  EXPECT_NE(svg.find("translate(34.0 34.0)"), std::string::npos) << svg;               // target
  EXPECT_NE(svg.find("translate(128.0 222.0)"), std::string::npos) << svg;             // source
  EXPECT_NE(svg.find("cx=\"222.0\" cy=\"222.0\" r=\"7\""), std::string::npos) << svg;  // speaker
}

class ReportTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("report." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    write_tiny_dataset(folder_ / "data");
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string report(const std::string& data) const {
    const auto set = soundspaces_evaluation_set(folder_ / "data", "test", {}, {}, 10 << 20);
    const std::vector<MethodEntry> methods{input_method(), network_method("co<py", "input"),
                                           oracle_methods().front()};
    SilentProgress silent;
    const EvaluationResult result = evaluate(*set, methods, {}, silent);
    ReportOptions options;
    options.data = data;
    options.split = "test";
    options.random_clips = 2;
    write_report(folder_ / "out/deep", *set, methods, result, options, silent);
    return read_text_file(folder_ / "out/deep/index.html");
  }

  fs::path folder_;
};

TEST_F(ReportTest, PageHoldsAllThatItShows) {
  const std::string html = report("some & data");
  EXPECT_NE(html.find("some &amp; data"), std::string::npos);
  // Five clips with three sounds each: input, the copy, the truth; no oracle.
  EXPECT_EQ(count(html, "<audio "), 15U);
  EXPECT_EQ(count(html, "aria-label=\"map from above\""), 5U);
  // The source's picture, waveforms, and spectrograms of both ears.
  EXPECT_EQ(count(html, "<img "), 20U);
  EXPECT_EQ(count(html, "best Mag of co&lt;py"), 1U);
  EXPECT_EQ(count(html, "drawn at random"), 2U);
  EXPECT_NE(html.find("oracle-gain"), std::string::npos);
  // The page loads nothing from outside, and no name became markup.
  EXPECT_EQ(html.find("http"), std::string::npos);
  EXPECT_EQ(html.find("co<py"), std::string::npos);
  EXPECT_EQ(count(html, "src=\""), count(html, "src=\"data:"));
  for (const char* tag : {"div", "table", "tr", "td", "svg", "details"}) {
    EXPECT_EQ(count(html, std::string("<") + tag + ">") + count(html, std::string("<") + tag + " "),
              count(html, std::string("</") + tag + ">"))
        << tag;
  }
}

TEST_F(ReportTest, SameSeedSamePage) { EXPECT_EQ(report("x"), report("x")); }

TEST_F(ReportTest, FolderThatCannotBeMadeIsAnError) {
  write_file(folder_ / "out", std::string_view("a file"));
  EXPECT_THROW((void)report("x"), InputError);
}

}  // namespace
}  // namespace earpoint
