#include "gtf_file.h"
#include "run_program.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/media/image_file.h>
#include <earpoint/media/media.h>
#include <earpoint/media/movie_writer.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

Waveform noise(double duration_s, int rate_hz) {
  Waveform sound(2, std::lround(duration_s * rate_hz), rate_hz);
  RandomStream random(5);
  for (float& sample : sound.planar()) sample = static_cast<float>(0.05 * random.normal());
  return sound;
}

class RenderCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(testing::TempDir()) / ("render_command_" + name);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    // No models here, regardless of the source tree: the default is dsp.
    ASSERT_EQ(::setenv("EARPOINT_MODELS_DIR", folder_.c_str(), 1), 0);
  }
  void TearDown() override {
    fs::remove_all(folder_);
    ::unsetenv("EARPOINT_MODELS_DIR");
  }

  [[nodiscard]] std::string at(const char* name) const { return (folder_ / name).string(); }

  [[nodiscard]] std::string sound(double duration_s = 1.5) const {
    write_sound(at("in.wav"), noise(duration_s, 16000), SampleFormat::float32);
    return at("in.wav");
  }

  [[nodiscard]] std::string movie() const {
    MovieWriter writer(at("clip.mp4"), 64, 48, 25.0, 48000);
    for (int i = 0; i < 50; ++i) writer.write_picture(Image(64, 48, 3, 100));
    writer.write_sound(noise(2.0, 48000));
    writer.close();
    return at("clip.mp4");
  }

  /// Exit 2, one line on standard error, no output file.
  void expect_refused(std::vector<std::string> arguments, const std::string& part) const {
    arguments.insert(arguments.begin(), "render");
    arguments.insert(arguments.end(), {"-o", at("out.wav"), "--quiet"});
    const ProgramOutcome outcome = run_earpoint(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.errors;
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
    EXPECT_NE(outcome.errors.find(part), std::string::npos) << outcome.errors;
    EXPECT_FALSE(fs::exists(at("out.wav")));
    for (const auto& entry : fs::directory_iterator(folder_)) {
      EXPECT_EQ(entry.path().string().find(".partial"), std::string::npos) << entry.path();
    }
  }

  fs::path folder_;
};

TEST_F(RenderCommand, NumbersThatMeanNothingAreRefusedByTheirFlag) {
  const std::string in = sound();
  for (const char* value : {"nan", "inf", "1e9"}) {
    for (const char* flag : {"--yaw", "--pitch", "--roll"}) {
      expect_refused({in, flag, value}, std::string(flag) + ": expected an angle");
    }
    for (const char* flag : {"--gain", "--fov", "--ambient-cutoff"}) {
      expect_refused({in, "--yaw", "0", flag, value},
                     std::string(flag) + ": expected a number from");
    }
  }
  expect_refused({in, "--translate", "1e9,0,0"}, "--translate: 1e+09 m is farther");
  expect_refused({in, "--translate", "nan,0,0"}, "--translate: expected 3 numbers");
  expect_refused({in, "--yaw", "0", "--speaker", "0,-1e9,0"}, "--speaker: -1e+09 m is farther");
}

TEST_F(RenderCommand, PeaksAreLimitedWithAWarningUnlessNotWished) {
  const std::string in = sound();
  const auto run = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"render", in,       "--model", "input", "--yaw",
                                       "0",      "--gain", "30",      "-o",    at("out.wav"),
                                       "--json", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramOutcome outcome = run_earpoint(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    return outcome;
  };
  const ProgramOutcome limited = run({});
  EXPECT_NE(limited.errors.find("above full scale were limited; --gain -"), std::string::npos)
      << limited.errors;
  const auto target = nlohmann::json::parse(limited.output)["targets"][0];
  EXPECT_LE(target["peak"].get<double>(), 1.0);
  EXPECT_GT(target["limited_db"].get<double>(), 3.0);
  const ProgramOutcome whole = run({"--no-limit"});
  EXPECT_NE(whole.errors.find("above full scale; --gain -"), std::string::npos) << whole.errors;
  EXPECT_GT(nlohmann::json::parse(whole.output)["targets"][0]["peak"].get<double>(), 1.4);
}

TEST_F(RenderCommand, ASpeakerPassedByChangesSides) {
  const ProgramOutcome outcome = run_earpoint(
      {"render", sound(), "--speaker", "2,0,0", "--translate", "2,1,0", "-o", at("left.wav"),
       "--translate", "2,-1,0", "-o", at("right.wav"), "--json", "--quiet"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto document = nlohmann::json::parse(outcome.output);
  ASSERT_EQ(document["targets"].size(), 2U);
  // With the head to the left of the speaker, facing the same way, the speaker is on the right.
  const auto& left = document["targets"][0];
  const auto& right = document["targets"][1];
  EXPECT_LT(left["left_db"].get<double>(), left["right_db"].get<double>() - 3.0);
  EXPECT_GT(right["left_db"].get<double>(), right["right_db"].get<double>() + 3.0);
  EXPECT_NE(outcome.errors.find("gtf.safetensors is not among"), std::string::npos)
      << outcome.errors;
}

TEST_F(RenderCommand, AMovieWithAMovingEarpointKeepsItsPictureAndLength) {
  write_file(at("walk.csv"),
             "time_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n0,0,0,0,0,0,0\n2,1,0,0,90,0,0\n");
  const ProgramOutcome outcome =
      run_earpoint({"render", movie(), "--speaker-box", "0.4,0.2,0.6,0.9", "--path", at("walk.csv"),
                    "-o", at("there.mp4"), "--plot", at("ears.png"), "--quiet"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const MediaInfo info = probe_media(at("there.mp4"));
  EXPECT_EQ(info.kind, MediaKind::movie);
  ASSERT_NE(info.preferred(StreamKind::audio), nullptr);
  EXPECT_EQ(info.preferred(StreamKind::audio)->sample_rate_hz, 48000);
  // Two AAC frames, of 21 ms each at 48 kHz.
  EXPECT_NEAR(info.duration_s.value_or(0.0), 2.0, 0.05);
  EXPECT_GT(read_image(at("ears.png")).height(), 100);
}

TEST_F(RenderCommand, APictureAndASoundMayComeInEitherOrder) {
  write_image(at("frame.png"), Image(64, 64, 3, 50));
  for (const bool swapped : {false, true}) {
    std::vector<std::string> arguments = {"render", at("frame.png"), sound()};
    if (swapped) std::swap(arguments[1], arguments[2]);
    arguments.insert(arguments.end(), {"--speaker-box", "0.4,0.2,0.6,0.9", "--yaw", "45", "-o",
                                       at("out.flac"), "--quiet"});
    const ProgramOutcome outcome = run_earpoint(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    EXPECT_EQ(read_sound(at("out.flac")).samples(), 24000);
  }
}

TEST_F(RenderCommand, AShippedNetworkIsTheDefaultAndHasAName) {
  write_gtf_file(at("gtf.safetensors"), 0);
  for (const std::vector<std::string>& model :
       {std::vector<std::string>{}, {"--model", "gtf"}, {"--model", at("gtf.safetensors")}}) {
    std::vector<std::string> arguments = {"render", sound(), "--speaker",   "2,0,0",  "--yaw",
                                          "45",     "-o",    at("out.wav"), "--json", "--quiet"};
    arguments.insert(arguments.end(), model.begin(), model.end());
    const ProgramOutcome outcome = run_earpoint(arguments);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
    const auto document = nlohmann::json::parse(outcome.output);
    EXPECT_EQ(document["model"], at("gtf.safetensors"));
    EXPECT_TRUE(document["warnings"].empty());
  }
}

TEST_F(RenderCommand, ATextureIsForNetworksThatKnowTwo) {
  write_gtf_file(at("two.safetensors"), 0, true, true);
  write_gtf_file(at("one.safetensors"), 0);
  const auto render_by = [&](const std::string& model, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"render",  sound(),       "--model",    model,
                                       "--quiet", "--translate", "1,0,0",      "--speaker",
                                       "2,0.5,0", "-o",          at("out.wav")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_earpoint(arguments);
  };
  const auto sound_of = [&](const std::vector<std::string>& more) {
    const ProgramOutcome outcome = render_by(at("two.safetensors"), more);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    return read_text_file(at("out.wav"));
  };
  const std::string natural = sound_of({});
  EXPECT_EQ(sound_of({"--texture", "natural"}), natural);
  EXPECT_EQ(sound_of({"--texture", "1"}), natural);
  const std::string mean = sound_of({"--texture", "mean"});
  EXPECT_NE(mean, natural);
  const std::string between = sound_of({"--texture", "0.5"});
  EXPECT_NE(between, natural);
  EXPECT_NE(between, mean);
  for (const char* wrong : {"1.5", "-0.1", "nan", "rough", ""}) {
    const ProgramOutcome refused = render_by(at("two.safetensors"), {"--texture", wrong});
    EXPECT_EQ(refused.exit_code, 2) << wrong;
    EXPECT_NE(refused.errors.find("natural, mean or a number"), std::string::npos)
        << refused.errors;
  }
  for (const std::string& model : {at("one.safetensors"), std::string("dsp")}) {
    const ProgramOutcome refused = render_by(model, {"--texture", "mean"});
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_NE(refused.errors.find("has one texture only"), std::string::npos) << refused.errors;
  }
}

TEST_F(RenderCommand, SaysWhenANetworkIsOutOfItsDepth) {
  write_gtf_file(at("gtf.safetensors"));
  const ProgramOutcome outcome = run_earpoint(
      {"render", sound(), "--translate", "9,0,0", "-o", at("out.wav"), "--json", "--quiet"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  // Too far, no picture, and no speaker given: one line each.
  EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 3) << outcome.errors;
  EXPECT_NE(outcome.errors.find("9.0 m"), std::string::npos) << outcome.errors;
  const nlohmann::json document = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(document["warnings"].size(), 3U);
  EXPECT_EQ(document["doubts"], document["warnings"]);
}

TEST_F(RenderCommand, BadArgumentsGetOneLine) {
  const std::string input = sound();
  expect_refused({input}, "no earpoint given");
  expect_refused({input, "--translate", "1,2"}, "expected 3 numbers");
  expect_refused({input, "--translate", "1,2,nan"}, "expected 3 numbers");
  expect_refused({input, "--translate", "1,0,0", "--translate", "2,0,0"}, "2 earpoints need");
  expect_refused({input, "--yaw", "90"}, "--speaker x,y,z");
  expect_refused({input, "--yaw", "90", "--speaker-box", "0.5,0.2,1.2,0.9"},
                 "extends beyond the picture");
  expect_refused({input, "--yaw", "90", "--model", "nothing.safetensors"}, "neither a known name");
  expect_refused({input, "--yaw", "90", "--model", input}, "in.wav");
  expect_refused({input, "--yaw", "90", "--model", "dsp", "--hrtf", input}, "in.wav");
  expect_refused({input, "--yaw", "90", "--model", "dsp", "--hrtf", at("missing.sofa")},
                 "missing.sofa: no such file");
  expect_refused({input, "--yaw", "90", "--model", "input", "--hrtf", at("missing.sofa")},
                 "only --model dsp uses head filters");
  expect_refused({input, "--to", at("missing.json")}, "no such file");
  expect_refused({input, "--translate", "1,0,0", "--colour", "red"}, "--colour");
  expect_refused({at("missing.wav"), "--yaw", "90", "--speaker", "2,0,0"}, "missing.wav");
  write_image(at("frame.png"), Image(64, 64, 3, 50));
  expect_refused({at("frame.png"), "--yaw", "90"}, "is a picture without sound");
  expect_refused({at("frame.png"), input, "--yaw", "90", "--model",
                  EARPOINT_SOURCE_DIR "/models/vigas.safetensors"},
                 "in.wav: the network needs the speaker's box");
}

TEST_F(RenderCommand, APathWithAGapIsRefused) {
  write_file(at("walk.csv"), "time_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n0,0,0,,0,0,0\n");
  expect_refused({sound(), "--speaker", "2,0,0", "--path", at("walk.csv")},
                 "line 2, z: the cell is empty");
}

TEST_F(RenderCommand, SamplesThatAreNoNumbersAreNamed) {
  const std::string input = sound();
  std::fstream file(input, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(-400, std::ios::end);
  const float not_a_number = std::nanf("");
  file.write(reinterpret_cast<const char*>(&not_a_number), sizeof(not_a_number));
  file.close();
  expect_refused({input, "--yaw", "90", "--speaker", "2,0,0"},
                 "has a NaN or infinite sample at 1.49");
}

TEST_F(RenderCommand, AFullDiskIsOneLineAndLeavesNothing) {
  // A memory file system of half a megabyte stands for the disk; making one needs privileges.
  const fs::path disk = folder_ / "disk";
  fs::create_directories(disk);
  const std::string mount = "mount -t tmpfs -o size=512k tmpfs " + disk.string() + " 2>/dev/null";
  if (std::system(mount.c_str()) != 0) GTEST_SKIP() << "cannot mount a small file system here";
  const ProgramOutcome outcome = run_earpoint({"render", sound(30.0), "--speaker", "2,0,0", "--yaw",
                                               "90", "-o", (disk / "out.wav").string(), "--quiet"});
  const bool empty = fs::is_empty(disk);
  EXPECT_EQ(std::system(("umount " + disk.string()).c_str()), 0);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
  EXPECT_NE(outcome.errors.find("space"), std::string::npos) << outcome.errors;
  EXPECT_TRUE(empty);
}

TEST_F(RenderCommand, HelpTeachesByExample) {
  const ProgramOutcome outcome = run_earpoint({"render", "--help"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_NE(outcome.output.find("earpoint render clip.mp4 --translate"), std::string::npos);
}

/// Runs a command line in a shell; EARPOINT stands for the program.
ProgramOutcome run_shell(std::string line) {
  const std::string program = "EARPOINT";
  for (std::size_t at = line.find(program); at != std::string::npos; at = line.find(program, at)) {
    line.replace(at, program.size(), EARPOINT_PROGRAM);
    at += std::string(EARPOINT_PROGRAM).size();
  }
  return run_program("/bin/bash", {"-c", line});
}

TEST_F(RenderCommand, PipesGoInAndOut) {
  const std::string in = sound();
  const std::string render = " --model input --yaw 0 --quiet";
  ProgramOutcome outcome =
      run_shell("set -o pipefail; cat " + in + " | EARPOINT render -" + render +
                " -o - | EARPOINT render -" + render + " -o " + at("out.wav"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const Waveform there = read_sound(at("out.wav"));
  EXPECT_TRUE(std::ranges::equal(there.planar(), read_sound(in).planar()));

  // Standard output has only the sound.
  outcome = run_shell("EARPOINT render " + in +
                      " --model input --yaw 0 -o - | { head -c 4; cat > /dev/null; }");
  EXPECT_EQ(outcome.output, "RIFF");
  EXPECT_NE(outcome.errors.find("source"), std::string::npos) << outcome.errors;
}

TEST_F(RenderCommand, AFullStandardOutputIsAnError) {
  const std::string in = sound();
  for (const std::string& command :
       {"render " + in + " --model input --yaw 0 -o " + at("out.wav"),
        "render " + in + " --model input --yaw 0 --quiet -o -", "metrics " + in + " " + in,
        std::string("--help"), std::string("render --help"), std::string("--version")}) {
    const ProgramOutcome outcome = run_shell("EARPOINT " + command + " > /dev/full");
    EXPECT_EQ(outcome.exit_code, 2) << command;
    EXPECT_NE(outcome.errors.find("standard output"), std::string::npos) << outcome.errors;
  }
}

TEST_F(RenderCommand, ASignalLeavesNothing) {
  const std::string in = sound(60.0);
  for (const std::string signal : {"INT", "TERM", "HUP"}) {
    // The signal ends it after the hidden file is created and before it is complete.
    const ProgramOutcome outcome = run_shell(
        "cd " + folder_.string() +
        "; set -m; EARPOINT render in.wav --model dsp --speaker 2,0,0 --yaw 10 --quiet -o out.wav "
        "&\n"
        "for i in $(seq 500); do ls .out*.partial.wav >/dev/null 2>&1 && break; sleep 0.01; done\n"
        "ls -A | grep -q partial && echo begun; kill -" +
        signal + " $!; wait $!; echo $?");
    EXPECT_TRUE(outcome.output.starts_with("begun\n1")) << outcome.output << outcome.errors;
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << signal;
  }
}

TEST_F(RenderCommand, OneFileUnderTwoNamesIsRefusedBeforeRendering) {
  const std::string in = sound();
  fs::create_symlink("same.wav", at("link.wav"));
  for (const std::string& other : {folder_.string() + "/./same.wav", at("link.wav")}) {
    const ProgramOutcome outcome =
        run_earpoint({"render", in, "--model", "input", "--yaw", "1", "--yaw", "2", "-o",
                      at("same.wav"), "-o", other, "--quiet"});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.errors.find("two earpoints would write this file"), std::string::npos)
        << outcome.errors;
  }
}

TEST_F(RenderCommand, ThePlotIsCheckedBeforeRendering) {
  expect_refused({sound(), "--model", "input", "--yaw", "1", "--plot", at("no/ears.png")},
                 "folder");
  expect_refused({sound(), "--model", "input", "--yaw", "1", "--plot", at("ears.txt")}, ".png");
}

TEST_F(RenderCommand, AYawForEachEarpointNeedsNoTranslation) {
  const ProgramOutcome outcome =
      run_earpoint({"render", sound(), "--model", "input", "--yaw", "10", "--yaw", "20", "--yaw",
                    "30", "-o", at("1.wav"), "-o", at("2.flac"), "-o", at("3.mp3"), "--quiet"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(read_sound(at("3.mp3")).samples(), read_sound(at("1.wav")).samples());
}

TEST_F(RenderCommand, ANameThatIsNoUtf8IsReplacedInJson) {
  const std::string out = folder_.string() + "/o\xff.wav";
  const ProgramOutcome outcome = run_earpoint(
      {"render", sound(), "--model", "input", "--yaw", "1", "-o", out, "--json", "--quiet"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_TRUE(nlohmann::json::accept(outcome.output));
  EXPECT_TRUE(fs::exists(out));
}

TEST_F(RenderCommand, TheFieldOfViewIsTakenFromThePictureOrSaid) {
  const std::string in = sound();
  write_image(at("frame.jpg"), Image(64, 48, 3));
  const std::vector<std::string> command = {
      "render",      at("frame.jpg"), in,  "--model", "dsp",        "--speaker-box",
      "16,12,32,36", "--yaw",         "1", "-o",      at("out.wav")};
  EXPECT_NE(run_earpoint(command).errors.find("field of view unknown, 90 degrees assumed"),
            std::string::npos);
  // 24 mm on 35 mm film: 71.6 degrees from side to side.
  const char exif[] =
      "\xff\xe1\0\x34"
      "Exif\0\0MM\0*\0\0\0\x08\0\1\x87\x69\0\4\0\0\0\1\0\0\0\x1a\0\0\0\0"
      "\0\1\xa4\5\0\3\0\0\0\1\0\x18\0\0\0\0\0\0";
  std::string jpeg = read_text_file(at("frame.jpg"));
  write_file(at("frame.jpg"), jpeg.insert(2, std::string(exif, sizeof(exif) - 1)));
  EXPECT_NE(run_earpoint(command).errors.find("field of view 72 degrees"), std::string::npos)
      << run_earpoint(command).errors;
}

}  // namespace
}  // namespace earpoint
