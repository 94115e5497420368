#include "test_media.h"

#include <array>
#include <functional>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/media/image_file.h>
#include <earpoint/media/media.h>
#include <earpoint/media/movie_writer.h>

namespace earpoint {
namespace {

class DamagedMedia : public MediaTest {
 protected:
  /// Reads all that there is to read, within reason: a damaged header may promise years of sound.
  void read_everything(const std::string& name) const {
    const auto ignore_input_error = [](const std::function<void()>& read) {
      (void)input_error(read);  // checks that it is one line; anything else fails the test
    };
    ignore_input_error([&] { (void)probe_media(file(name)); });
    ignore_input_error([&] { (void)read_image(file(name)); });
    ignore_input_error([&] {
      FrameReader reader(file(name));
      for (const double t : {0.0, 0.33, 0.97, 0.1, 5.0, 0.5}) (void)reader.frame_nearest(t);
    });
    ignore_input_error([&] {
      AudioReader reader(file(name), std::array{0, 1});
      for (int block = 0; block < 50 && reader.read(8000).samples() > 0; ++block) {
      }
    });
    ignore_input_error([&] {
      MovieWriter writer(file("out.mp4"), file(name), 16000);
      writer.write_sound(Waveform(2, 16000, 16000));
      writer.close();
    });
  }

  /// One second of coloured noise with sound.
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
    }
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
      // Half of the rounds aim at the index, where a single bit does most.
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
}

TEST_F(DamagedMedia, FlippedBitsInPicturesGiveAnErrorOrAPicture) {
  RandomStream random(12);
  Image image(40, 30, 3);
  for (auto& value : image.pixels()) value = static_cast<std::uint8_t>(random.index(256));
  for (const char* name : {"a.png", "a.jpg"}) {
    write_image(file(name), image);
    const std::string whole = read_text_file(file(name));
    for (int round = 0; round < 200; ++round) {
      std::string damaged = whole;
      for (int flip = 0; flip <= round % 5; ++flip) {
        char& byte = damaged[random.index(round % 2 == 0 ? damaged.size() : 700)];
        byte = static_cast<char>(byte ^ (1 << random.index(8)));
      }
      write_file(file(name), damaged);
      (void)input_error([&] { (void)read_image(file(name)); });
      (void)input_error([&] { (void)probe_media(file(name)); });
    }
  }
}

}  // namespace
}  // namespace earpoint
