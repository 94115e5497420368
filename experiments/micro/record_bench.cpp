// How long it takes to prepare a session: 3 minutes, 8 cameras of 1280 x 720 at 25 frames a second.
// Run it on one core (taskset -c 0): `record_bench FOLDER`. The folder keeps the session.

#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>

#include <fmt/format.h>

#include <earpoint/audio/resample.h>
#include <earpoint/core/progress.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/media/movie_writer.h>
#include <earpoint/plot/draw.h>
#include <earpoint/record/prepare.h>
#include <earpoint/record/session.h>
#include <earpoint/record_testing/test_session.h>

namespace {

namespace fs = std::filesystem;
using namespace earpoint;

constexpr double kDuration_s = 180.0;
constexpr int kWidth = 1280;
constexpr int kHeight = 720;
constexpr double kFrameRate_hz = 25.0;
constexpr int kSoundRate_hz = 48000;

/// A room with grain, through which two bars walk: for a codec and PNG neither empty nor pure
/// noise.
Image picture(const Image& room, int frame) {
  Image image = room;
  for (int person = 0; person < 2; ++person) {
    const int x = (200 + 500 * person + (3 - 5 * person) * frame) % kWidth;
    fill_rect(image, {(x + kWidth) % kWidth, 200, 120, 450},
              {static_cast<std::uint8_t>(90 + 60 * person), 60, 110});
  }
  return image;
}

/// The pictures of all cameras.
void write_pictures(const fs::path& path) {
  Image room(kWidth, kHeight, 3);
  RandomStream random(1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double grain = 4.0 * random.normal();
      for (int c = 0; c < 3; ++c) {
        room.at(x, y, c) = static_cast<std::uint8_t>(100 + x / 20.0 + y / 15.0 + 10 * c + grain);
      }
    }
  }
  MovieWriter writer(path, kWidth, kHeight, kFrameRate_hz, kSoundRate_hz);
  const int frames = static_cast<int>((kDuration_s + 5.0) * kFrameRate_hz);
  for (int frame = 0; frame < frames; ++frame) writer.write_picture(picture(room, frame));
  writer.write_sound(Waveform(2, kSoundRate_hz, kSoundRate_hz));
  writer.close();
}

fs::path make_session(const fs::path& folder) {
  fs::path file = folder / "session" / "session.json";
  if (fs::exists(file)) return file;
  TestSession made = make_test_session({.cameras = 8, .people = 3, .duration_s = kDuration_s});
  write_test_session(folder / "session", made);
  const fs::path pictures = folder / "pictures.mp4";
  write_pictures(pictures);
  for (std::size_t c = 0; c < made.session.cameras.size(); ++c) {
    MovieWriter writer(made.session.cameras[c].video, pictures, kSoundRate_hz);
    writer.write_sound(resample(made.sounds.devices[c].sound, kSoundRate_hz));
    writer.close();
  }
  return file;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    fmt::print(stderr, "usage: record_bench FOLDER\n");
    return 2;
  }
  const fs::path folder = argv[1];
  const Session session = read_session(make_session(folder));
  fs::remove_all(folder / "out");
  SilentProgress silent;
  const std::clock_t begin = std::clock();
  const auto start = std::chrono::steady_clock::now();
  const PrepareSummary made =
      prepare_session(session, {.out = folder / "out", .split = "test"}, silent);
  const double cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  const double wall_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  fmt::print("{} clips of {} cameras from {:.0f} s: {:.1f} s of processor time, {:.1f} s in all;\n",
             made.clips, made.cameras, kDuration_s, cpu_s, wall_s);
  fmt::print("per camera {:.3f} of the session's duration\n", cpu_s / made.cameras / kDuration_s);
  return 0;
} catch (const InputError& error) {
  fmt::print(stderr, "record_bench: {}\n", error.what());
  return 2;
}
