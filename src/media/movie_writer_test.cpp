#include "test_media.h"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/resource.h>

#include <earpoint/core/random.h>
#include <earpoint/media/media.h>
#include <earpoint/media/movie_writer.h>

namespace earpoint {
namespace {

constexpr double kFrameRateHz = 25.0;
constexpr int kFrames = 50;

bool is_flash(int frame) { return frame == 10 || frame == 31; }

/// Two seconds with a click in both ears at the beginning of each white frame.
Waveform clicks(int rate, int channel_delay = 0) {
  Waveform sound(2, std::ptrdiff_t{2} * rate, rate);
  for (int frame = 0; frame < kFrames; ++frame) {
    if (!is_flash(frame)) continue;
    const auto at = static_cast<std::size_t>(std::lround(frame * rate / kFrameRateHz));
    for (std::size_t i = 0; i < 8; ++i) {
      sound.channel(0)[at + i] = 0.7F;
      sound.channel(1)[at + i + static_cast<std::size_t>(channel_delay)] = 0.5F;
    }
  }
  return sound;
}

Image flat(int level, int width = 64, int height = 48) {
  return Image(width, height, 3, static_cast<std::uint8_t>(level));
}

void write_in_blocks(MovieWriter& writer, const Waveform& sound, std::ptrdiff_t block) {
  for (std::ptrdiff_t begin = 0; begin < sound.samples(); begin += block) {
    const std::ptrdiff_t count = std::min(block, sound.samples() - begin);
    Waveform part(2, count, sound.sample_rate_hz());
    for (int ear = 0; ear < 2; ++ear) {
      const auto from = sound.channel(ear).subspan(static_cast<std::size_t>(begin),
                                                   static_cast<std::size_t>(count));
      std::copy(from.begin(), from.end(), part.channel(ear).begin());
    }
    writer.write_sound(part);
  }
}

std::vector<double> flash_times(const std::filesystem::path& path) {
  FrameReader reader(path);
  std::vector<double> times_s;
  for (double t = 0.0; t < reader.duration_s(); t += 0.25 / kFrameRateHz) {
    if (reader.frame_nearest(t).at(32, 24, 1) < 128) continue;
    if (times_s.empty() || reader.frame_time_s() > times_s.back()) {
      times_s.push_back(reader.frame_time_s());
    }
  }
  return times_s;
}

/// Times of the loudest samples, one per click.
std::vector<double> click_times(const std::filesystem::path& path, int ear) {
  AudioReader reader(path);
  const Waveform sound = reader.read(1 << 24);
  const auto samples = sound.channel(ear);
  std::vector<double> times_s;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (std::abs(samples[i]) < 0.25F) continue;
    const double time_s = static_cast<double>(i) / sound.sample_rate_hz();
    if (times_s.empty() || time_s > times_s.back() + 0.1) times_s.push_back(time_s);
  }
  return times_s;
}

// AAC smears a click's edge by part of a millisecond; a picture's clock ticks in fractions of one.
constexpr double kToleranceSeconds = 0.002;

void expect_together(const std::filesystem::path& path, double offset_s = 0.0) {
  const std::vector<double> flashes = flash_times(path);
  ASSERT_EQ(flashes.size(), 2U);
  EXPECT_NEAR(flashes[0], 0.4 + offset_s, kToleranceSeconds);
  EXPECT_NEAR(flashes[1], 1.24 + offset_s, kToleranceSeconds);
  for (const int ear : {0, 1}) {
    const std::vector<double> times_s = click_times(path, ear);
    ASSERT_EQ(times_s.size(), 2U) << ear;
    EXPECT_NEAR(times_s[0], flashes[0], kToleranceSeconds) << ear;
    EXPECT_NEAR(times_s[1], flashes[1], kToleranceSeconds) << ear;
  }
}

class MovieWriterTest : public MediaTest {
 protected:
  void write_flashes(const std::string& name, int rate) const {
    MovieWriter writer(file(name), 64, 48, kFrameRateHz, rate);
    for (int frame = 0; frame < kFrames; ++frame)
      writer.write_picture(flat(is_flash(frame) ? 255 : 0));
    write_in_blocks(writer, clicks(rate), 1000);
    writer.close();
  }
};

TEST_F(MovieWriterTest, FlashesAndClicksCoincide) {
  for (const int rate : {16000, 22050, 44100, 48000}) {
    SCOPED_TRACE(rate);
    write_flashes("a.mp4", rate);
    expect_together(file("a.mp4"));
    AudioReader reader(file("a.mp4"));
    EXPECT_EQ(reader.sample_rate_hz(), rate);
    EXPECT_EQ(reader.read(std::ptrdiff_t{10} * rate).samples(), 2 * rate) << "no delay, no filling";

    // Another program finds the clicks at the same time.
    run_ffmpeg("-i a.mp4 -c:a pcm_s16le a.wav");
    const std::vector<double> heard = click_times(file("a.wav"), 0);
    ASSERT_EQ(heard.size(), 2U);
    EXPECT_NEAR(heard[0], 0.4, kToleranceSeconds);
  }
  EXPECT_EQ(entries(), 3) << "a.mp4, a.wav, ffmpeg.log";
}

TEST_F(MovieWriterTest, EarsStayApart) {
  MovieWriter writer(file("a.mp4"), 64, 48, kFrameRateHz, 48000);
  writer.write_picture(flat(0));
  Waveform sound(2, 48000, 48000);
  for (std::size_t i = 0; i < 48000; ++i) {
    sound.channel(0)[i] = 0.5F * std::sin(0.05F * static_cast<float>(i));
  }
  writer.write_sound(sound);
  writer.close();
  AudioReader reader(file("a.mp4"));
  const Waveform heard = reader.read(48000);
  double left = 0.0;
  double right = 0.0;
  for (std::size_t i = 0; i < 48000; ++i) {
    left += std::pow(heard.channel(0)[i], 2);
    right += std::pow(heard.channel(1)[i], 2);
  }
  EXPECT_NEAR(left / 48000, 0.125, 0.005);  // the power of a sine of 0.5
  EXPECT_LT(right / left, 1e-6);            // 60 dB below
}

TEST_F(MovieWriterTest, SoundIsReplacedAndThePictureCopied) {
  write_flashes("a.mp4", 44100);
  for (const auto& [name, conversion, codec] :
       {std::tuple{"copy.mp4", "-c:v copy", "h264"}, std::tuple{"copy.mkv", "-c:v copy", "h264"},
        std::tuple{"b.mp4", "-c:v libx264 -bf 3 -g 5", "h264"},
        std::tuple{"b.mov", "-c:v libx265 -x265-params log-level=none", "hevc"},
        std::tuple{"b.webm", "-c:v libvpx-vp9 -b:v 1M -c:a libvorbis", "vp9"},
        std::tuple{"av1.webm", "-c:v libaom-av1 -cpu-used 8 -c:a libvorbis", "av1"},
        std::tuple{"c.mov", "-c:v mjpeg -q:v 3", "h264"},  // encoded anew
        std::tuple{"vp8.webm", "-c:v libvpx -b:v 1M -c:a libvorbis", "h264"},
        std::tuple{"c.avi", "-c:v mpeg4 -bf 2", "h264"}, std::tuple{"c.ts", "-c:v copy", "h264"}}) {
    SCOPED_TRACE(name);
    run_ffmpeg(fmt::format("-i a.mp4 {} {}", conversion, name));
    const std::vector<double> before = flash_times(file(name));
    MovieWriter writer(file("out.mp4"), file(name), 48000);
    // When the first flash comes on this source's clock: an encoder's delay may shift it.
    const double offset_s = before.at(0) - 0.4;
    Waveform sound = clicks(48000);
    Waveform shifted(2, sound.samples() + 4800, 48000);
    for (int ear = 0; ear < 2; ++ear) {
      std::copy(sound.channel(ear).begin(), sound.channel(ear).end(),
                shifted.channel(ear).begin() + std::lround(offset_s * 48000));
    }
    write_in_blocks(writer, shifted, 5000);
    writer.close();
    expect_together(file("out.mp4"), offset_s);
    const MediaInfo info = probe_media(file("out.mp4"));
    EXPECT_EQ(info.preferred(StreamKind::video)->codec, codec);
    EXPECT_EQ(info.preferred(StreamKind::audio)->codec, "aac");
    EXPECT_EQ(info.streams.size(), 2U);
  }
}

/// Compares every frame of both movies at the same times.
void expect_same_pictures(const std::filesystem::path& a, const std::filesystem::path& b) {
  FrameReader first(a);
  FrameReader second(b);
  EXPECT_EQ(first.info().rotation_deg, second.info().rotation_deg);
  for (double t = 0.0; t < first.duration_s() + 0.1; t += 0.011) {
    const Image image = first.frame_nearest(t);
    const Image copy = second.frame_nearest(t);
    ASSERT_EQ(image.width(), copy.width());
    ASSERT_TRUE(std::equal(image.pixels().begin(), image.pixels().end(), copy.pixels().begin()))
        << t;
    // Both containers' clocks tick in milliseconds or finer and start alike: rounding of one tick
    // of 1/12800 s.
    ASSERT_NEAR(first.frame_time_s(), second.frame_time_s(), 1e-4) << t;
  }
}

TEST_F(MovieWriterTest, CopiedFramesKeepTimeRotationAndContent) {
  const std::string numbered =
      "-f lavfi -i testsrc2=s=64x48:r=25:d=3 -f lavfi -i sine=d=3 -c:v libx264 -bf 3 -g 20 ";
  run_ffmpeg(numbered + "a.mp4");
  // Cut between key frames: the copy begins before t = 0 and an edit list hides that part.
  run_ffmpeg("-ss 1.3 -i a.mp4 -c copy cut.mp4");
  run_ffmpeg("-i a.mp4 -c copy -metadata:s:v:0 rotate=90 turned.mp4");
  // The picture begins late; the sound begins late.
  run_ffmpeg("-i a.mp4 -itsoffset 0.7 -i a.mp4 -map 0:a -map 1:v -c copy late_picture.mp4");
  run_ffmpeg("-i a.mp4 -itsoffset 0.7 -i a.mp4 -map 1:a -map 0:v -c copy late_sound.mp4");
  run_ffmpeg(
      "-f lavfi -i \"testsrc2=s=64x48:r=10:d=2,settb=1/1000,setpts=N*N*10\" "
      "-fps_mode passthrough -enc_time_base 1/1000 -c:v libx264 -bf 2 variable.mp4");
  for (const char* name :
       {"a.mp4", "cut.mp4", "turned.mp4", "late_picture.mp4", "late_sound.mp4", "variable.mp4"}) {
    SCOPED_TRACE(name);
    MovieWriter writer(file("out.mp4"), file(name), 16000);
    write_in_blocks(writer, Waveform(2, 16000, 16000), 16000);
    writer.close();
    expect_same_pictures(file(name), file("out.mp4"));
  }
}

TEST_F(MovieWriterTest, TheContainerFollowsTheExtension) {
  write_flashes("a.mp4", 44100);
  for (const auto& [name, format] :
       {std::pair{"b.mov", "mov"}, {"b.mkv", "matroska"}, {"b.MP4", "mp4"}}) {
    MovieWriter writer(file(name), file("a.mp4"), 44100);
    writer.write_sound(clicks(44100));
    writer.close();
    EXPECT_TRUE(mentions(probe_media(file(name)).format, format)) << name;
    EXPECT_GT(FrameReader(file(name)).frame_nearest(0.0).width(), 0);
  }
}

TEST_F(MovieWriterTest, PicturesFromBeforeTimeZeroOfAMatroskaFileAreKept) {
  run_ffmpeg(
      "-f lavfi -i testsrc2=s=64x48:r=25:d=2 -f lavfi -i sine=d=2 -ac 2 -c:v libx264 -bf 0 -c:a "
      "aac "
      "-output_ts_offset -1 -avoid_negative_ts disabled a.mkv");
  MovieWriter writer(file("b.mp4"), file("a.mkv"), 44100);
  writer.write_sound(Waveform(2, 88200, 44100));
  writer.close();
  EXPECT_NEAR(FrameReader(file("b.mp4")).duration_s(), 2.0, 0.1);  // a frame or two at the edges
}

TEST_F(MovieWriterTest, PicturesComeBackInTheirColours) {
  Image image(35, 27, 3);  // odd: one more column and row in the file
  for (int y = 0; y < 27; ++y) {
    for (int x = 0; x < 35; ++x) {
      image.at(x, y, 0) = 230;
      image.at(x, y, 1) = 120;
      image.at(x, y, 2) = 30;
    }
  }
  MovieWriter writer(file("a.mp4"), 35, 27, 30000.0 / 1001.0, 44100);
  for (int i = 0; i < 5; ++i) writer.write_picture(image);
  writer.write_sound(Waveform(2, 4410, 44100));
  writer.close();
  FrameReader reader(file("a.mp4"));
  EXPECT_EQ(reader.info().width, 36);
  EXPECT_EQ(reader.info().height, 28);
  EXPECT_DOUBLE_EQ(reader.frame_rate_hz(), 30000.0 / 1001.0);
  const Image read = reader.frame_nearest(0.1);
  for (const int x : {0, 17, 35}) {
    // Rounding to 8 bits of YCbCr is up to 1 in each of three, which the matrix adds up; coding
    // adds another step.
    EXPECT_NEAR(read.at(x, 14, 0), 230, 4);
    EXPECT_NEAR(read.at(x, 14, 1), 120, 4);
    EXPECT_NEAR(read.at(x, 27, 2), 30, 4);
  }
}

TEST_F(MovieWriterTest, AMovieMayReplaceItsSource) {
  write_flashes("a.mp4", 16000);
  MovieWriter writer(file("a.mp4"), file("a.mp4"), 48000);
  writer.write_sound(clicks(48000));
  writer.close();
  expect_together(file("a.mp4"));
  EXPECT_EQ(AudioReader(file("a.mp4")).sample_rate_hz(), 48000);
  EXPECT_EQ(entries(), 1);
}

TEST_F(MovieWriterTest, SameInputGivesTheSameBytes) {
  write_flashes("a.mp4", 44100);
  write_flashes("b.mp4", 44100);
  EXPECT_EQ(read_text_file(file("a.mp4")), read_text_file(file("b.mp4")));
}

TEST_F(MovieWriterTest, SameMovingPicturesGiveTheSameBytesWhateverWasInMemoryBefore) {
  const auto film = [&](const char* name, int garbage) {
    mallopt(M_PERTURB, garbage);  // what fresh memory is filled with
    MovieWriter writer(file(name), 160, 90, 5.0, 48000);
    RandomStream random(1);
    for (int frame = 0; frame < 40; ++frame) {
      Image image = flat(90, 160, 90);
      for (std::uint8_t& value : image.pixels()) {
        value = static_cast<std::uint8_t>(value + random.index(20));
      }
      const int left = 2 * frame;  // somebody who walks
      for (int y = 20; y < 80; ++y) {
        for (int x = left; x < left + 30; ++x) image.at(x, y, 1) = 200;
      }
      writer.write_picture(image);
    }
    writer.write_sound(clicks(48000));
    writer.close();
    mallopt(M_PERTURB, 0);
    return read_text_file(file(name));
  };
  const std::string first = film("a.mp4", 0);
  for (const int garbage : {1, 77, 200}) EXPECT_TRUE(film("b.mp4", garbage) == first) << garbage;
}

TEST_F(MovieWriterTest, WithoutCloseNothingIsLeft) {
  write_file(file("a.mp4"), "what was here before");
  {
    MovieWriter writer(file("a.mp4"), 64, 48, kFrameRateHz, 44100);
    writer.write_picture(flat(9));
    writer.write_sound(clicks(44100));
  }
  EXPECT_EQ(entries(), 1);
  EXPECT_EQ(read_text_file(file("a.mp4")), "what was here before");
}

TEST_F(MovieWriterTest, BadInputIsOneLineAndLeavesNothing) {
  write_flashes("a.mp4", 44100);
  run_ffmpeg("-i a.mp4 -vn sound.m4a");
  const auto opening = [&](const char* path, const char* source, int rate) {
    return input_error([&] { MovieWriter(file(path), file(source), rate); });
  };
  EXPECT_TRUE(mentions(opening("b.mp4", "sound.m4a", 44100), "sound.m4a: has no video stream"));
  EXPECT_TRUE(mentions(opening("b.mp4", "missing.mp4", 44100), "no such file"));
  EXPECT_TRUE(mentions(opening("b.mp4", "a.mp4", 37800), "37800 Hz"));
  EXPECT_TRUE(mentions(opening("b.avi", "a.mp4", 44100), "not '.avi'"));
  EXPECT_TRUE(mentions(opening("no/b.mp4", "a.mp4", 44100), "folder"));

  MovieWriter writer(file("b.mp4"), file("a.mp4"), 44100);
  Waveform sound = clicks(44100);
  sound.channel(0)[5000] = std::numeric_limits<float>::quiet_NaN();
  const std::string message = input_error([&] { writer.write_sound(sound); });
  EXPECT_TRUE(mentions(message, "b.mp4: the sound cannot be encoded")) << message;
  EXPECT_THROW(writer.write_sound(clicks(44100)), std::logic_error) << "the movie is lost";
  EXPECT_FALSE(std::filesystem::exists(file("b.mp4")));
}

TEST_F(MovieWriterTest, DamageInTheSourceNamesTheSource) {
  RandomStream random(5);
  MovieWriter long_movie(file("a.mp4"), 64, 48, kFrameRateHz, 44100);
  Image image = flat(0);
  for (int i = 0; i < 200; ++i) {
    for (auto& value : image.pixels()) value = static_cast<std::uint8_t>(random.index(256));
    long_movie.write_picture(image);
  }
  long_movie.write_sound(clicks(44100));
  long_movie.close();
  const std::string movie = read_text_file(file("a.mp4"));
  write_file(file("a.mp4"), movie.substr(0, movie.size() / 2));

  MovieWriter writer(file("b.mp4"), file("a.mp4"), 44100);
  const std::string message = input_error([&] {
    writer.write_sound(clicks(44100));
    writer.close();
  });
  EXPECT_TRUE(mentions(message, "a.mp4: video stream 0")) << message;
}

/// For its lifetime no file of this process may grow beyond the size: like a full disk, but safe.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    previous_handler_ = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &previous_);
    const rlimit limit{bytes, previous_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &previous_);
    (void)std::signal(SIGXFSZ, previous_handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit previous_{};
  void (*previous_handler_)(int) = nullptr;
};

TEST_F(MovieWriterTest, AFullDiskIsOneLineAndLeavesNothing) {
  // The disk is full at once, in the middle, and when the index is moved to the front.
  write_flashes("whole.mp4", 44100);
  const auto size = std::filesystem::file_size(file("whole.mp4"));
  for (const auto limit : {std::uintmax_t{1}, size / 2, size - 100}) {
    const std::string message = input_error([&] {
      const FileSizeLimit full(limit);
      write_flashes("a.mp4", 44100);
    });
    EXPECT_TRUE(mentions(message, "a.mp4: cannot be written (File too large)")) << message;
    EXPECT_EQ(entries(), 1) << limit;
  }
}

}  // namespace
}  // namespace earpoint
