#include "test_media.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/media/media.h>

namespace earpoint {
namespace {

class FrameReaderTest : public MediaTest {
 protected:
  /// A movie whose frame number is its grey level.
  void make_numbered(const std::string& arguments, double seconds = 2.0, int rate = 25) const {
    run_ffmpeg(
        fmt::format("-f lavfi -i \"nullsrc=s=64x48:r={}:d={},"
                    "geq=lum='16+4*mod(N,50)':cb=128:cr=128,format=yuv420p\" {}",
                    rate, seconds, arguments));
  }
};

int number_of(const Image& image) {
  const double luma = 16.0 + image.at(image.width() / 2, image.height() / 2, 1) * 219.0 / 255.0;
  return static_cast<int>(std::lround((luma - 16.0) / 4.0));
}

int nearest_of(const std::vector<double>& times_s, double time_s) {
  int best = 0;
  for (int i = 1; i < static_cast<int>(times_s.size()); ++i) {
    if (std::abs(times_s[i] - time_s) < std::abs(times_s[best] - time_s) - 1e-6) best = i;
  }
  return best;
}

std::vector<double> regular_times(int count, double rate_hz, double start_s = 0.0) {
  std::vector<double> times_s(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) times_s[static_cast<std::size_t>(i)] = start_s + i / rate_hz;
  return times_s;
}

void expect_nearest(FrameReader& reader, const std::vector<double>& times_s, double time_s) {
  const Image image = reader.frame_nearest(time_s);
  const int expected = nearest_of(times_s, time_s);
  EXPECT_EQ(number_of(image), expected % 50) << "at " << time_s;
  // Half a tick of the coarsest clock, Matroska's millisecond.
  EXPECT_NEAR(reader.frame_time_s(), times_s[static_cast<std::size_t>(expected)], 6e-4);
}

TEST_F(FrameReaderTest, FindsTheNearestFrameInEveryContainer) {
  for (const auto& [name, codec] :
       {std::pair{"a.mp4", "-c:v libx264 -crf 10 -bf 3 -g 12"},
        std::pair{"a.mkv", "-c:v libx264 -crf 10 -bf 3 -g 12"},
        std::pair{"a.webm", "-c:v libvpx-vp9 -lossless 1 -g 12"},
        std::pair{"a.mov", "-c:v mjpeg -q:v 2"},
        std::pair{"b.mp4", "-c:v libx265 -x265-params log-level=none:lossless=1 -g 12"},
        std::pair{"a.ts", "-c:v libx264 -crf 10 -bf 3 -g 12"}}) {
    make_numbered(fmt::format("{} {}", codec, name));
    FrameReader reader(file(name));
    SCOPED_TRACE(name);
    // Matroska's clock ticks in milliseconds, at the beginning and at the end.
    EXPECT_NEAR(reader.duration_s(), 2.0, 0.002);
    EXPECT_DOUBLE_EQ(reader.frame_rate_hz(), 25.0);
    const std::vector<double> times_s = regular_times(50, 25.0);
    for (double t = 0.003; t < 2.2; t += 0.0137) expect_nearest(reader, times_s, t);
    EXPECT_EQ(reader.frames_decoded(), 50) << "each frame once";

    RandomStream random(3);
    for (int i = 0; i < 30; ++i) expect_nearest(reader, times_s, random.uniform(-0.2, 2.4));
  }
}

TEST_F(FrameReaderTest, ATieGoesToTheEarlierFrame) {
  make_numbered("-c:v libx264 a.mp4");
  FrameReader reader(file("a.mp4"));
  for (int i = 0; i < 49; ++i) EXPECT_EQ(number_of(reader.frame_nearest((i + 0.5) / 25.0)), i);
}

TEST_F(FrameReaderTest, BeforeAndBehindTheMovieIsItsFirstAndLastFrame) {
  make_numbered("-c:v libx264 a.mp4");
  FrameReader reader(file("a.mp4"));
  EXPECT_EQ(number_of(reader.frame_nearest(1e9)), 49);
  EXPECT_EQ(number_of(reader.frame_nearest(-1e9)), 0);
  EXPECT_THROW((void)reader.frame_nearest(std::numeric_limits<double>::quiet_NaN()),
               std::logic_error);
}

TEST_F(FrameReaderTest, FarAheadItSeeksInsteadOfDecodingAll) {
  for (const char* name : {"a.mp4", "a.mkv"}) {
    make_numbered(fmt::format("-c:v libx264 -g 25 {}", name), 20.0);
    FrameReader reader(file(name));
    const std::vector<double> times_s = regular_times(500, 25.0);
    expect_nearest(reader, times_s, 0.0);
    expect_nearest(reader, times_s, 18.51);
    // Two groups of pictures and the frames in the decoder's threads.
    EXPECT_LT(reader.frames_decoded(), 80) << name;
    expect_nearest(reader, times_s, 1.0);
    EXPECT_LT(reader.frames_decoded(), 160) << name;
  }
}

TEST_F(FrameReaderTest, TimesCountFromTheContainersStart) {
  // The picture begins 0.4 s after the sound.
  make_numbered("-c:v libx264 -bf 2 v.mp4");
  run_ffmpeg(
      "-f lavfi -i sine=440:d=2 -itsoffset 0.4 -i v.mp4 -map 1:v -map 0:a -c:v copy -c:a aac "
      "a.mp4");
  FrameReader late(file("a.mp4"));
  // Edit lists count milliseconds.
  EXPECT_NEAR(late.info().start_s, 0.4, 1e-3);
  const std::vector<double> times_s = regular_times(50, 25.0, 0.4);
  for (const double t : {0.0, 0.3, 0.42, 0.95, 2.1, 0.5}) expect_nearest(late, times_s, t);

  // A clock that does not begin at 0.
  run_ffmpeg("-i v.mp4 -c copy -muxdelay 0 -output_ts_offset 77 b.ts");
  FrameReader offset(file("b.ts"));
  for (const double t : {0.0, 0.3, 1.9, 0.1}) expect_nearest(offset, regular_times(50, 25.0), t);
}

TEST_F(FrameReaderTest, MeasuresADurationThatIsNotStated) {
  // As browsers record.
  make_numbered("-c:v libvpx-vp9 -live 1 -f webm pipe: > live.webm");
  EXPECT_FALSE(probe_media(file("live.webm")).duration_s.has_value());
  FrameReader reader(file("live.webm"));
  EXPECT_NEAR(reader.duration_s(), 2.0, 0.041);  // the last frame's own duration may be unknown
  EXPECT_EQ(number_of(reader.frame_nearest(1.9)), 47);
}

TEST_F(FrameReaderTest, FollowsAVariableFrameRate) {
  std::vector<double> times_s(20);
  for (std::size_t n = 0; n < 20; ++n) times_s[n] = static_cast<double>(n * n) * 0.01;
  for (const char* name : {"a.mp4", "a.mkv"}) {
    run_ffmpeg(
        fmt::format("-f lavfi -i \"nullsrc=s=64x48:r=10:d=2,geq=lum='16+4*N':cb=128:cr=128,"
                    "settb=1/1000,setpts=N*N*10,format=yuv420p\" -fps_mode passthrough "
                    "-enc_time_base 1/1000 -c:v libx264 -crf 10 -bf 2 {}",
                    name));
    FrameReader reader(file(name));
    SCOPED_TRACE(name);
    for (double t = 0.0; t < 3.7; t += 0.043) expect_nearest(reader, times_s, t);
    for (const double t : {1.4, 0.02, 3.5, 2.0}) expect_nearest(reader, times_s, t);
  }
}

TEST_F(FrameReaderTest, DoesWithoutTimestamps) {
  // AVI has none, and MPEG-4 frames with B-frames are stored out of order.
  make_numbered("-c:v mpeg4 -q:v 2 -bf 2 a.avi");
  FrameReader reader(file("a.avi"));
  const std::vector<double> times_s = regular_times(50, 25.0);
  EXPECT_EQ(number_of(reader.frame_nearest(0.0)), 0);
  const double first_s = reader.frame_time_s();
  for (const double t : {0.0, 0.5, 1.02, 0.2, 1.9}) {
    EXPECT_EQ(number_of(reader.frame_nearest(t + first_s)), nearest_of(times_s, t)) << t;
  }
}

TEST_F(FrameReaderTest, ShowsTheMovieUpright) {
  // A red upper left corner on black, rotated by the display matrix.
  run_ffmpeg(
      "-f lavfi -i color=black:s=64x32:r=25:d=0.2,drawbox=0:0:16:16:red:fill "
      "-pix_fmt yuv444p -c:v libx264 v.mp4");
  struct Case {
    int tag_deg;  // as ffmpeg 5.1 takes it: the clockwise turn is 360 - tag
    int clockwise_deg;
    int x, y;  // where the red corner ends up
  };
  for (const Case& c :
       {Case{0, 0, 4, 4}, Case{270, 90, 28, 4}, Case{180, 180, 60, 28}, Case{90, 270, 4, 60}}) {
    run_ffmpeg(fmt::format("-i v.mp4 -c copy -metadata:s:v:0 rotate={} r.mp4", c.tag_deg));
    FrameReader reader(file("r.mp4"));
    EXPECT_EQ(reader.info().rotation_deg, c.clockwise_deg);
    const Image image = reader.frame_nearest(0.0);
    EXPECT_EQ(image.width(), reader.info().width);
    EXPECT_EQ(image.width(), c.clockwise_deg % 180 == 0 ? 64 : 32);
    EXPECT_GT(image.at(c.x, c.y, 0), 200) << c.clockwise_deg;
    EXPECT_LT(image.at(image.width() - 1 - c.x, image.height() - 1 - c.y, 0), 20);
  }
}

TEST_F(FrameReaderTest, KnowsItsColours) {
  // An orange that differs between the two common matrices, in both ranges.
  struct Case {
    const char* size;
    const char* matrix;
    const char* tag;
    const char* range;
  };
  for (const Case& c : {Case{"64x48", "bt709", "-colorspace bt709", "tv"},
                        Case{"64x48", "bt601", "-colorspace smpte170m", "tv"},
                        Case{"64x48", "bt709", "-colorspace bt709", "pc"},
                        Case{"64x48", "bt601", "", "tv"},        // not said: small is BT.601
                        Case{"1280x720", "bt709", "", "tv"}}) {  // and large BT.709
    run_ffmpeg(
        fmt::format("-f lavfi -i color=0xff8020:s={}:r=25:d=0.1,format=rgb24 -vf "
                    "scale=out_color_matrix={}:out_range={},format=yuv444p {} "
                    "-color_range {} -c:v libx264 -crf 1 a.mp4",
                    c.size, c.matrix, c.range, c.tag, c.range));
    const Image image = FrameReader(file("a.mp4")).frame_nearest(0.0);
    // Rounding to 8 bits of YCbCr is up to 1 in each of three, which the matrix adds up; a wrong
    // matrix differs by 10 or more.
    EXPECT_NEAR(image.at(9, 9, 0), 0xff, 3) << c.matrix << c.tag << c.range;
    EXPECT_NEAR(image.at(9, 9, 1), 0x80, 3) << c.matrix << c.tag << c.range;
    EXPECT_NEAR(image.at(9, 9, 2), 0x20, 3) << c.matrix << c.tag << c.range;
  }
}

TEST_F(FrameReaderTest, DamageIsToldWithStreamAndTime) {
  run_ffmpeg(
      "-f lavfi -i testsrc2=s=128x96:r=25:d=2 -c:v libx264 -g 50 -movflags +faststart a.mp4");
  std::string movie = read_text_file(file("a.mp4"));
  // Bytes 60 % to 65 % of the file: pictures of the second second.
  for (std::size_t i = movie.size() * 60 / 100; i < movie.size() * 65 / 100; ++i) movie[i] = 0x5a;
  write_file(file("b.mp4"), movie);
  FrameReader reader(file("b.mp4"));
  EXPECT_NO_THROW((void)reader.frame_nearest(0.1));
  const std::string message = input_error([&] { (void)reader.frame_nearest(1.9); });
  EXPECT_TRUE(mentions(message, "b.mp4: video stream 0 at ")) << message;
  EXPECT_TRUE(mentions(message, "damaged")) << message;
  // The reader stays usable.
  EXPECT_NO_THROW((void)reader.frame_nearest(0.1));
}

TEST_F(FrameReaderTest, AFileCutShortIsToldSo) {
  for (const char* name : {"a.mp4", "a.mkv"}) {
    run_ffmpeg(
        fmt::format("-f lavfi -i testsrc2=s=128x96:r=25:d=2 -c:v libx264 "
                    "-movflags +faststart {}",
                    name));
    const std::string movie = read_text_file(file(name));
    write_file(file(name), movie.substr(0, movie.size() * 2 / 3));
    FrameReader reader(file(name));
    EXPECT_NO_THROW((void)reader.frame_nearest(0.1)) << name;
    const std::string message = input_error([&] { (void)reader.frame_nearest(1.99); });
    EXPECT_TRUE(mentions(message, name)) << message;
    EXPECT_TRUE(mentions(message, "video stream 0 at ")) << message;
  }
  // The table of contents comes last and is missing.
  run_ffmpeg("-f lavfi -i testsrc2=s=128x96:r=25:d=2 -c:v libx264 b.mp4");
  const std::string movie = read_text_file(file("b.mp4"));
  write_file(file("b.mp4"), movie.substr(0, movie.size() * 2 / 3));
  const std::string message = input_error([&] { FrameReader(file("b.mp4")); });
  EXPECT_TRUE(mentions(message, "moov atom not found")) << message;
}

}  // namespace
}  // namespace earpoint
