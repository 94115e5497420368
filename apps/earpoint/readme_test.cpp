#include "gtf_file.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/media/image_file.h>
#include <earpoint/media/media.h>
#include <earpoint/record_testing/test_session.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// The commands in README's code blocks, in their order.
std::vector<std::string> readme_commands() {
  std::istringstream readme(read_text_file(EARPOINT_SOURCE_DIR "/README.md"));
  std::vector<std::string> commands;
  bool in_block = false;
  bool continued = false;
  for (std::string line; std::getline(readme, line);) {
    if (line.starts_with("```")) in_block = !in_block;
    if (continued) commands.back() += "\n" + line;
    if (in_block && line.starts_with("earpoint ")) commands.push_back(line);
    continued = in_block && line.ends_with("\\") && !commands.empty();
  }
  return commands;
}

/// The first two seconds of a sound.
Waveform beginning_of(const Waveform& sound) {
  Waveform part(sound.channels(), 2 * sound.sample_rate_hz(), sound.sample_rate_hz());
  for (int c = 0; c < sound.channels(); ++c) {
    std::copy_n(sound.channel(c).begin(), part.samples(), part.channel(c).begin());
  }
  return part;
}

/// Fills a folder with the files that README names.
void fill(const fs::path& folder) {
  const fs::path examples = EARPOINT_SOURCE_DIR "/examples";
  const fs::path mini = EARPOINT_SOURCE_DIR "/src/networks/vigas/testdata/C_mini_noresnet";
  fs::copy(examples, folder / "examples");
  fs::copy_file(examples / "clip.mp4", folder / "clip.mp4");
  fs::copy_file(examples / "walk.csv", folder / "walk.csv");
  fs::copy_file(mini / "best_val.ckpt", folder / "best_val.ckpt");
  fs::copy_file(mini / "inputs.safetensors", folder / "inputs.safetensors");
  write_image(folder / "frame.png", FrameReader(examples / "clip.mp4").frame_nearest(0.0));
  write_sound(folder / "sound.flac", beginning_of(read_sound(examples / "truth-far-away.flac")));
  write_sound(folder / "reference.wav",
              beginning_of(read_sound(examples / "truth-in-the-next-room.flac")));
  write_sound(folder / "estimate.wav", beginning_of(read_sound(examples / "truth-far-away.flac")));
  write_gtf_file(folder / "gtf.safetensors");
  fs::copy_file(EARPOINT_SOURCE_DIR "/lab/scene/testdata/room.glb", folder / "flat.glb");
  write_file(folder / "room-walk.csv",
             "time_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n0,5,1,1.6,90,0,0\n2,3,4,1.6,180,0,0\n");
  TestSession session =
      make_test_session({.cameras = 3, .people = 1, .duration_s = 16.0, .reverberation_s = 0.0});
  write_test_session(folder, session);
  fs::create_directory(folder / "speech");
  write_file(folder / "speech" / "speech.csv",
             "file,speaker,gender,split\n"
             "../sound.flac,one,female,test\n"
             "../reference.wav,another,male,test\n");
}

TEST(Readme, EveryCommandWorksAsItStands) {
  const fs::path folder =
      fs::path(testing::TempDir()) / ("readme_commands." + std::to_string(::getpid()));
  fs::remove_all(folder);
  fs::create_directories(folder);
  fill(folder);
  const std::vector<std::string> commands = readme_commands();
  EXPECT_GE(commands.size(), 6U);
  const fs::path program_folder = fs::path(EARPOINT_PROGRAM).parent_path();
  for (const std::string& command : commands) {
    // On a line of its own, since some end in a comment.
    const std::string line = "cd '" + folder.string() + "' && PATH='" + program_folder.string() +
                             "':\"$PATH\" && {\n" + command + "\n} >out.txt 2>&1";
    EXPECT_EQ(std::system(line.c_str()), 0) << command << "\n"
                                            << read_text_file(folder / "out.txt");
  }
  EXPECT_TRUE(fs::exists(folder / "there.mp4"));
  EXPECT_TRUE(fs::exists(folder / "outputs.safetensors"));
  EXPECT_TRUE(fs::exists(folder / "data/homes/pairs-test.json"));
  EXPECT_TRUE(fs::exists(folder / "out/index.html"));
  EXPECT_TRUE(fs::exists(folder / "heard/index.html"));
  fs::remove_all(folder);
}

}  // namespace
}  // namespace earpoint
