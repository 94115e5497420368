#include "test_media.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/media/image_file.h>
#include <earpoint/media/media.h>
#include <earpoint/media/movie_writer.h>

namespace earpoint {
namespace {

/// How often a reader accepted a file, and how often it refused it.
struct Outcomes {
  int accepted = 0;
  int refused = 0;
};

class DamagedMedia : public MediaTest {
 protected:
  /// Reads everything, up to a limit, as a damaged header may state years of sound. Accepted
  /// contents must match the header.
  void read_everything(const std::string& name) {
    probe_ = attempt([&] { expect_sound_info(probe_media(file(name))); });
    EXPECT_EQ(attempt([&] { (void)read_image(file(name)); }).accepted, 0) << "a movie is no image";
    frames_ = attempt([&] {
      FrameReader reader(file(name));
      for (const double t : {0.0, 0.33, 0.97, 0.1, 5.0, 0.5}) {
        const Image frame = reader.frame_nearest(t);
        EXPECT_FALSE(frame.empty());
        EXPECT_EQ(frame.channels(), 3);
        EXPECT_EQ(frame.width(), reader.info().width);
        EXPECT_EQ(frame.height(), reader.info().height);
        EXPECT_TRUE(std::isfinite(reader.frame_time_s()));
      }
    });
    sound_ = attempt([&] {
      AudioReader reader(file(name), std::array{0, 1});
      EXPECT_GT(reader.sample_rate_hz(), 0);
      std::ptrdiff_t samples = 0;
      for (int block = 0; block < 50; ++block) {
        const Waveform read = reader.read(8000);
        EXPECT_LE(read.samples(), 8000);
        samples += read.samples();
        if (read.samples() == 0) break;
        EXPECT_EQ(read.channels(), 2);
      }
      EXPECT_GT(samples, 0) << "the reader promises to refuse what holds no sample";
    });
    std::filesystem::remove(file("out.mp4"));
    written_ = attempt([&] {
      MovieWriter writer(file("out.mp4"), file(name), 16000);
      writer.write_sound(Waveform(2, 16000, 16000));
      writer.close();
    });
    EXPECT_EQ(std::filesystem::exists(file("out.mp4")), written_.accepted == 1);
    if (written_.accepted == 1) expect_second_of_sound(file("out.mp4"));
    for (const Outcomes& outcome : {probe_, frames_, sound_, written_}) {
      all_.accepted += outcome.accepted;
      all_.refused += outcome.refused;
    }
  }

  /// Reads; an InputError, which must be one line, is a refusal, anything else fails the test.
  static Outcomes attempt(const std::function<void()>& read) {
    const bool refused = !input_error(read).empty();
    return {refused ? 0 : 1, refused ? 1 : 0};
  }

  static void expect_sound_info(const MediaInfo& info) {
    EXPECT_FALSE(info.format.empty());
    EXPECT_FALSE(info.streams.empty());
    if (info.duration_s) {
      EXPECT_TRUE(std::isfinite(*info.duration_s));
      EXPECT_GE(*info.duration_s, 0.0);
    }
    for (const StreamInfo& stream : info.streams) {
      EXPECT_TRUE(std::isfinite(stream.start_s));
      EXPECT_GE(stream.start_s, 0.0);
      if (stream.duration_s) {
        EXPECT_TRUE(std::isfinite(*stream.duration_s));
      }
      EXPECT_TRUE(std::isfinite(stream.frame_rate_hz));
      EXPECT_GE(stream.width, 0);
      EXPECT_GE(stream.height, 0);
      EXPECT_EQ(stream.rotation_deg % 90, 0);
      EXPECT_GE(stream.channels, 0);
      EXPECT_GE(stream.sample_rate_hz, 0);
    }
  }

  /// A written movie is complete even if the source of its pictures is damaged: it has a picture
  /// and a second of sound.
  static void expect_second_of_sound(const std::filesystem::path& path) {
    EXPECT_NE(probe_media(path).preferred(StreamKind::video), nullptr);
    AudioReader reader(path);
    EXPECT_EQ(reader.sample_rate_hz(), 16000);
    std::ptrdiff_t samples = 0;
    while (const std::ptrdiff_t read = reader.read(8000).samples()) samples += read;
    // AAC comes in blocks of 1024 samples, of which the last may be padding.
    EXPECT_GE(samples, 16000);
    EXPECT_LE(samples, 16000 + 1024);
  }

  Outcomes probe_, frames_, sound_, written_;  // of the file read last
  Outcomes all_;

  /// One second of a test picture with noise as sound.
  void make_movie(const std::string& name, const std::string& codecs) const {
    run_ffmpeg(
        fmt::format("-f lavfi -i testsrc2=s=64x48:r=25:d=1 -f lavfi -i "
                    "anoisesrc=d=1:r=16000:a=0.3 -ac 2 {} -movflags +faststart {}",
                    codecs, name));
  }
};

constexpr std::array<std::array<const char*, 2>, 4> kKinds = {
    {{"a.mp4", "-c:v libx264 -bf 2 -c:a aac -b:a 32k"},
     {"a.mkv", "-c:v libx264 -bf 2 -c:a flac"},
     {"a.webm", "-c:v libvpx-vp9 -cpu-used 8 -c:a libopus -ar 48000"},
     {"a.mov", "-c:v mjpeg -c:a pcm_s16le"}}};

TEST_F(DamagedMedia, AFileCutAnywhereGivesAnErrorOrWhatIsThere) {
  for (const auto& [name, codecs] : kKinds) {
    make_movie(name, codecs);
    const std::string whole = read_text_file(file(name));
    for (std::size_t part = 0; part <= 24; ++part) {
      SCOPED_TRACE(fmt::format("{} {}/24", name, part));
      write_file(file(name), whole.substr(0, whole.size() * part / 24));
      read_everything(name);
      if (part == 0) {
        EXPECT_EQ(probe_.accepted + frames_.accepted + sound_.accepted + written_.accepted, 0);
      }
    }
    EXPECT_EQ(probe_.accepted + frames_.accepted + sound_.accepted + written_.accepted, 4)
        << name << " is whole";
  }
}

TEST_F(DamagedMedia, FlippedBitsGiveAnErrorOrAPicture) {
  RandomStream random(11);
  for (const auto& [name, codecs] : kKinds) {
    make_movie(name, codecs);
    const std::string whole = read_text_file(file(name));
    for (int round = 0; round < 60; ++round) {
      SCOPED_TRACE(fmt::format("{} round {}", name, round));
      std::string damaged = whole;
      // Half of the rounds damage the index, where single bits do most harm.
      const std::size_t reach =
          round % 2 == 0 ? damaged.size() : std::min<std::size_t>(1500, damaged.size());
      for (int flip = 0; flip <= round % 7; ++flip) {
        char& byte = damaged[random.index(reach)];
        byte = static_cast<char>(byte ^ (1 << random.index(8)));
      }
      write_file(file(name), damaged);
      read_everything(name);
    }
  }
  // Both kinds must be common among the 960 outcomes; otherwise there was too little damage, or too
  // much.
  EXPECT_GT(all_.accepted, 200);
  EXPECT_GT(all_.refused, 50);
}

TEST_F(DamagedMedia, FlippedBitsInPicturesGiveAnErrorOrAPicture) {
  RandomStream random(12);
  Image image(40, 30, 3);
  for (auto& value : image.pixels()) value = static_cast<std::uint8_t>(random.index(256));
  for (const char* name : {"a.png", "a.jpg"}) {
    write_image(file(name), image);
    const std::string whole = read_text_file(file(name));
    Outcomes outcomes;
    for (int round = 0; round < 200; ++round) {
      SCOPED_TRACE(fmt::format("{} round {}", name, round));
      std::string damaged = whole;
      for (int flip = 0; flip <= round % 5; ++flip) {
        char& byte = damaged[random.index(round % 2 == 0 ? damaged.size() : 700)];
        byte = static_cast<char>(byte ^ (1 << random.index(8)));
      }
      write_file(file(name), damaged);
      std::optional<Image> read;
      std::optional<MediaInfo> info;
      outcomes.refused += attempt([&] { read = read_image(file(name)); }).refused;
      attempt([&] { info = probe_media(file(name)); });
      if (info) expect_sound_info(*info);
      if (!read) continue;
      ++outcomes.accepted;
      EXPECT_EQ(read->channels(), 3);
      EXPECT_GT(read->width(), 0);
      EXPECT_GT(read->height(), 0);
      EXPECT_LE(static_cast<double>(read->width()) * read->height(), 1e8) << "100 megapixels";
    }
    EXPECT_GT(outcomes.refused, 5) << name;
    // Every byte of a PNG is under a checksum, so that all damage is detected; JPEG has no
    // checksums.
    if (name == std::string("a.png")) {
      EXPECT_EQ(outcomes.accepted, 0);
    } else {
      EXPECT_GT(outcomes.accepted, 5);
    }
  }
}

}  // namespace
}  // namespace earpoint
