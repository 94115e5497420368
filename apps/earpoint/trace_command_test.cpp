#include "run_program.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <earpoint/audio/energy.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class TraceCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(testing::TempDir()) / ("trace_command_" + name);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    output_ = (folder_ / "brir.wav").string();
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::vector<std::string> arguments(const std::vector<std::string>& more) const {
    std::vector<std::string> all = {"trace",    "--shoebox",  "6,5,3,absorption=0.3,scattering=0.4",
                                    "--source", "3,4,1.5",    "--listener",
                                    "3,2,1.5",  "--duration", "0.4",
                                    "--rays",   "500",        "-o",
                                    output_};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  /// Exit 2, one line on standard error, nothing written.
  /// @return that line
  std::string refusal(const std::vector<std::string>& all) {
    const ProgramOutcome outcome = run_earpoint(all);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
    EXPECT_FALSE(fs::exists(output_));
    return outcome.errors;
  }

  /// The usual arguments with one of them changed.
  std::string refusal(const std::string& old_text, const std::string& new_text) {
    std::vector<std::string> all = arguments({});
    std::replace(all.begin(), all.end(), old_text, new_text);
    return refusal(all);
  }

  fs::path folder_;
  std::string output_;
};

TEST_F(TraceCommand, SourceOnTheLeftIsLouderOnTheLeft) {
  // The listener looks along x and the source is towards y: to the left.
  const ProgramOutcome outcome = run_earpoint(arguments({}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(outcome.output, "");
  const Waveform brir = read_sound(output_);
  EXPECT_EQ(brir.channels(), 2);
  EXPECT_EQ(brir.sample_rate_hz(), 16000);
  EXPECT_EQ(brir.samples(), 6400);
  EXPECT_GT(energy(brir.channel(0)), 1.5 * energy(brir.channel(1)));
}

TEST_F(TraceCommand, TurnedHeadHearsItOnTheRight) {
  std::vector<std::string> turned = arguments({});
  std::replace(turned.begin(), turned.end(), std::string("3,2,1.5"),
               std::string("3,2,1.5,yaw=180"));
  ASSERT_EQ(run_earpoint(turned).exit_code, 0);
  const Waveform brir = read_sound(output_);
  EXPECT_GT(energy(brir.channel(1)), 1.5 * energy(brir.channel(0)));
}

TEST_F(TraceCommand, MonoStartsAfterTheWayAndReportsDecays) {
  const ProgramOutcome outcome = run_earpoint(arguments({"--mono", "--report", "--rate", "48000"}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  for (const char* part : {"T30 s", "C50 dB", "8000", "escape fraction 0,", "distance 2.000 m"}) {
    EXPECT_NE(outcome.output.find(part), std::string::npos) << outcome.output;
  }
  const Waveform response = read_sound(output_);
  ASSERT_EQ(response.channels(), 1);
  const std::span<const float> samples = response.channel(0);
  const auto peak = std::max_element(samples.begin(), samples.end());
  // 2 m at 343.2 m/s, to the nearest sample.
  EXPECT_NEAR(static_cast<double>(peak - samples.begin()), 2.0 / 343.2 * 48000, 1.0);
}

TEST_F(TraceCommand, SameSeedGivesTheSameBytesForAnyNumberOfJobs) {
  ASSERT_EQ(run_earpoint(arguments({"--seed", "7", "--jobs", "1"})).exit_code, 0);
  const std::vector<std::byte> one = read_file(output_);
  ASSERT_EQ(run_earpoint(arguments({"--seed", "7", "--jobs", "2"})).exit_code, 0);
  EXPECT_EQ(one, read_file(output_));
  ASSERT_EQ(run_earpoint(arguments({"--seed", "8"})).exit_code, 0);
  EXPECT_NE(one, read_file(output_));
}

TEST_F(TraceCommand, RefusesBadArgumentsInOneLine) {
  EXPECT_EQ(refusal("500", "0"), "earpoint: --rays: expected 1 to 100000000, found 0\n");
  for (const char* duration : {"-1", "1e-9", "0.005", "31", "nan"}) {
    EXPECT_NE(refusal("0.4", duration).find("--duration: expected 0.01 to 30, found "),
              std::string::npos)
        << duration;
  }
  EXPECT_EQ(refusal(arguments({"--rate", "2000000000"})),
            "earpoint: --rate: expected 8000 to 192000, found 2000000000\n");
  EXPECT_EQ(refusal(arguments({"--seed", "-1"})),
            "earpoint: --seed: expected a whole number of 0 or more, found '-1'; see "
            "--help\n");
  EXPECT_NE(refusal(arguments({"--temperature", "400"})).find("temperature"), std::string::npos);
  EXPECT_EQ(refusal(arguments({"--mono", "--hrtf", "head.sofa"})),
            "earpoint: --mono: a single microphone has no HRTF; leave out --mono or --hrtf\n");
  EXPECT_NE(refusal(arguments({"--hrtf", "nothing.sofa"})).find("nothing.sofa"), std::string::npos);
}

TEST_F(TraceCommand, RefusesAResponseThatEndsBeforeTheSoundComes) {
  // 50 m take 146 ms.
  EXPECT_EQ(refusal({"trace", "--shoebox", "60,5,3", "--source", "1,1,1", "--listener", "51,1,1",
                     "--duration", "0.1", "-o", output_}),
            "earpoint: --duration: ends after 0.1 s, before the sound arrives after 0.146 s; use "
            "--duration 0.2 or more\n");
}

TEST_F(TraceCommand, WarnsWhereTheResponseIsCutOff) {
  const auto warning = [&](const std::string& room) {
    std::vector<std::string> all = arguments({"--mono"});
    std::replace(all.begin(), all.end(), std::string("6,5,3,absorption=0.3,scattering=0.4"), room);
    const ProgramOutcome outcome = run_earpoint(all);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    return outcome.errors;
  };
  EXPECT_EQ(warning("6,5,3,absorption=0.9,scattering=0.4"), "");
  const std::string line = warning("6,5,3,absorption=0.1,scattering=0.4");
  EXPECT_EQ(line.find("earpoint: warning: the response ends at -"), 0U) << line;
  const std::string flag = "use --duration ";
  ASSERT_NE(line.find(flag), std::string::npos) << line;
  // Eyring's time is 1 s; -60 dB re the loudest is a little earlier or later.
  EXPECT_NEAR(std::stod(line.substr(line.find(flag) + flag.size())), 1.1, 0.35) << line;
}

TEST_F(TraceCommand, SaysThatASourceIsOutsideOfTheWallsOrInOne) {
  // A room of 5 x 4 x 3 m with a garden wall 10 m away.
  const std::string model = (folder_ / "garden.obj").string();
  write_file(model, std::string_view("v 0 0 0\nv 5 0 0\nv 5 4 0\nv 0 4 0\nv 0 0 3\n"
                                     "v 5 0 3\nv 5 4 3\nv 0 4 3\nv 15 0 0\nv 15 4 0\n"
                                     "v 15 4 3\ng brick\nf 1 2 3 4\nf 5 6 7 8\n"
                                     "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
                                     "f 9 10 11\n"));
  const auto with_source = [&](const std::string& source) {
    return refusal({"trace", model, "--up", "z", "--source", source, "--listener", "2,2,1.5",
                    "--rays", "500", "-o", output_});
  };
  EXPECT_NE(with_source("10,2,1.5").find("the source: is outside the walls"), std::string::npos);
  EXPECT_NE(with_source("5,2,1.5").find("the source: is on a surface"), std::string::npos);
}

TEST_F(TraceCommand, TracesAModelInTheCoordinatesOfALandSurvey) {
  // A room of 5 x 4 x 3 m with a corner far from the origin.
  std::string text;
  for (const int z : {100, 103}) {
    for (const auto& [x, y] : {std::pair{0, 0}, {5, 0}, {5, 4}, {0, 4}}) {
      text += fmt::format("v {} {} {}\n", 500000 + x, 5800000 + y, z);
    }
  }
  const std::string model = (folder_ / "survey.obj").string();
  write_file(model, text +
                        "g brick\nf 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\n"
                        "f 3 4 8 7\nf 4 1 5 8\n");
  const ProgramOutcome outcome = run_earpoint(
      {"trace", model, "--up", "z", "--source", "500001,5800002,101.5", "--listener",
       "500003,5800002,101.5", "--duration", "0.1", "--rays", "200", "--report", "-o", output_});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("distance 2.000 m"), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.errors.find("precision is only 0.5 m"), std::string::npos) << outcome.errors;
  const ProgramOutcome outside =
      run_earpoint({"trace", model, "--up", "z", "--source", "1,2,1.5", "--listener",
                    "500003,5800002,101.5", "--duration", "30", "-o", output_});
  EXPECT_EQ(outside.exit_code, 2);
  EXPECT_NE(outside.errors.find("which spans x 500000 to 500005, y 5800000 to 5800004"),
            std::string::npos)
      << outside.errors;
}

TEST_F(TraceCommand, TracesAModelFileWithItsOptions) {
  // An L-shaped room with a corner at the origin, 6 m along x and 4 m along y.
  const std::string room = EARPOINT_SOURCE_DIR "/lab/scene/testdata/room.glb";
  const ProgramOutcome outcome = run_earpoint(
      {"trace", room, "--source", "3,1,1.4", "--listener", "1,1,1.4,yaw=90", "--up", "y", "--unit",
       "1", "--duration", "0.3", "--rays", "200", "-o", output_, "--report"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("distance 2.000 m"), std::string::npos) << outcome.output;
  EXPECT_EQ(outcome.output.find("none"), std::string::npos) << "nothing stands in the way";
  // It looks along y; the source lies along x: on the right.
  const Waveform brir = read_sound(output_);
  EXPECT_GT(energy(brir.channel(1)), 1.5 * energy(brir.channel(0)));
}

TEST_F(TraceCommand, ClosesAModelWithoutACeiling) {
  // A box of 5 x 4 x 3 m, z up, in centimetres; the names of its surfaces are its own.
  const std::string model = (folder_ / "open.obj").string();
  write_file(model, std::string_view("v 0 0 0\nv 500 0 0\nv 500 400 0\nv 0 400 0\n"
                                     "v 0 0 300\nv 500 0 300\nv 500 400 300\n"
                                     "v 0 400 300\ng carpet\nf 1 2 3 4\ng brick\n"
                                     "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"));
  std::vector<std::string> all = {
      "trace",      model,     "--up",       "z",   "--unit", "0.01", "--source", "1,1,1.5",
      "--listener", "3,2,1.5", "--duration", "0.2", "--rays", "200",  "-o",       output_};
  const ProgramOutcome open = run_earpoint(all);
  EXPECT_EQ(open.exit_code, 2);
  EXPECT_NE(open.errors.find("the mesh: leaks: "), std::string::npos) << open.errors;
  EXPECT_NE(open.errors.find("--close-ceiling"), std::string::npos) << open.errors;
  EXPECT_FALSE(fs::exists(output_));
  all.emplace_back("--close-ceiling");
  const ProgramOutcome closed = run_earpoint(all);
  EXPECT_EQ(closed.exit_code, 0) << closed.errors;
  EXPECT_GT(energy(read_sound(output_).channel(0)), 0.0);
}

TEST_F(TraceCommand, RefusesAListenerWhomNoSoundReaches) {
  // Two closed boxes of 2 x 2 x 2 m, 1 m apart.
  const auto box = [](int x, int first) {
    std::string text;
    for (const int z : {0, 2}) {
      for (const auto& [dx, y] : {std::pair{0, 0}, {2, 0}, {2, 2}, {0, 2}}) {
        text += fmt::format("v {} {} {}\n", x + dx, y, z);
      }
    }
    for (const auto& [a, b, c, d] : {std::array{1, 2, 3, 4},
                                     {5, 6, 7, 8},
                                     {1, 2, 6, 5},
                                     {2, 3, 7, 6},
                                     {3, 4, 8, 7},
                                     {4, 1, 5, 8}}) {
      text += fmt::format("f {} {} {} {}\n", first + a, first + b, first + c, first + d);
    }
    return text;
  };
  const std::string model = (folder_ / "boxes.obj").string();
  write_file(model, "g concrete\n" + box(0, 0) + box(3, 8));
  const std::vector<std::string> all = {"trace",  model,        "--up",  "z",          "--source",
                                        "1,1,1",  "--listener", "4,1,1", "--duration", "0.2",
                                        "--rays", "100",        "-o",    output_};
  const std::string line = refusal(all);
  EXPECT_EQ(line,
            "earpoint: --listener: no sound reaches it; place it in the room of the source\n");
}

TEST_F(TraceCommand, AmbisonicMicrophoneHasItsChannels) {
  ASSERT_EQ(run_earpoint(arguments({"--ambisonics", "2"})).exit_code, 0);
  const Waveform sound = read_sound(output_);
  ASSERT_EQ(sound.channels(), 9);
  // The source is on the left: in the direct sound the second channel, which points there, is
  // sqrt(3) times the first. Other normalisations give 1 or sqrt(2).
  const int place = static_cast<int>(std::lround(2.0 / 343.2 * 16000));
  EXPECT_NEAR(sound.channel(1)[place] / sound.channel(0)[place], std::sqrt(3.0), 0.01);
  std::filesystem::remove(output_);
  EXPECT_EQ(refusal(arguments({"--ambisonics", "8"})),
            "earpoint: --ambisonics: expected an order of 1 to 7, found 8\n");
  EXPECT_NE(refusal(arguments({"--ambisonics", "2", "--mono"})).find("one of the three"),
            std::string::npos);
}

TEST_F(TraceCommand, TalkerIsLouderInFront) {
  // The listener is in direction -y of the source.
  const auto level = [&](const std::string& source) {
    std::vector<std::string> all = arguments({"--mono", "--directivity", "speech"});
    std::replace(all.begin(), all.end(), std::string("3,4,1.5"), source);
    const ProgramOutcome outcome = run_earpoint(all);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    return energy(read_sound(output_).channel(0));
  };
  EXPECT_GT(level("3,4,1.5,yaw=-90"), 1.5 * level("3,4,1.5,yaw=90"));
}

TEST_F(TraceCommand, TracesAHomeDrawnFromASeed) {
  const ProgramOutcome outcome =
      run_earpoint({"trace", "--home", "3", "--source", "3,2,1.4", "--listener", "1,1,1.4",
                    "--duration", "0.2", "--rays", "100", "-o", output_});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_GT(energy(read_sound(output_).channel(0)), 0.0);
}

TEST_F(TraceCommand, RefusesScenesThatAreNotNamedOnce) {
  const std::vector<std::string> places = {"--source", "3,4,1.5", "--listener",
                                           "3,2,1.5",  "-o",      output_};
  const auto with = [&](std::vector<std::string> scene) {
    scene.insert(scene.begin(), "trace");
    scene.insert(scene.end(), places.begin(), places.end());
    return refusal(scene);
  };
  EXPECT_EQ(with({}), "earpoint: scene: none is given; give one of SCENE, --shoebox and --home\n");
  EXPECT_EQ(with({"room.glb", "--home", "3"}),
            "earpoint: scene: several are given; give one of SCENE, --shoebox and --home\n");
  EXPECT_EQ(with({"--home", "3", "--close-ceiling"}),
            "earpoint: --close-ceiling: applies only to a scene that is read from a file; leave it "
            "out\n");
  EXPECT_NE(with({"--home", "-1"}).find("--home"), std::string::npos);
  EXPECT_NE(with({"room.glb"}).find("room.glb: does not exist"), std::string::npos);
  EXPECT_NE(with({"room.fbx"}).find("expected a .glb"), std::string::npos);
}

TEST_F(TraceCommand, RefusesPlacesThatMakeNoSense) {
  EXPECT_EQ(refusal("3,4,1.5", "3,4"),
            "earpoint: --source: expected three numbers in metres, found '3,4'\n");
  EXPECT_EQ(refusal("3,4,1.5", "3,4,x"), "earpoint: --source: expected a number, found 'x'\n");
  EXPECT_EQ(refusal("3,2,1.5", "3,2,1.5,jaw=4"),
            "earpoint: --listener: unknown 'jaw'; known: yaw, pitch and roll, in degrees\n");
  EXPECT_EQ(refusal("3,2,1.5", "3,4,1.5"),
            "earpoint: --listener: is at the position of the source; move one of them\n");
  const std::string room = "6,5,3,absorption=0.3,scattering=0.4";
  EXPECT_EQ(refusal(room, "6,5,0"),
            "earpoint: --shoebox: expected lengths of 0.01 m or more, found 0\n");
  EXPECT_NE(refusal(room, "6,5,3,absorption=2").find("outside [0, 1]"), std::string::npos);
  EXPECT_EQ(refusal("3,4,1.5", "3,9,1.5"),
            "earpoint: --source: (3, 9, 1.5) is outside the scene, which spans x 0 to 6, y 0 to "
            "5, z 0 to 3 m; place it inside\n");
  EXPECT_NE(refusal("3,2,1.5", "3,2,-1").find("--listener: (3, 2, -1) is outside"),
            std::string::npos);
}

class TraceMotionCommand : public TraceCommand {
 protected:
  void SetUp() override {
    TraceCommand::SetUp();
    path_ = (folder_ / "walk.csv").string();
    write_file(path_, std::string_view("time_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n"
                                       "0,5,2.5,1.5,0,0,0\n"
                                       "0.5,1,2.5,1.5,90,0,0\n"));
  }

  [[nodiscard]] static std::vector<std::string> with(std::vector<std::string> more) {
    std::vector<std::string> all = {
        "trace",  "--shoebox", "6,5,3,absorption=0.9,scattering=0.4", "--duration", "0.2",
        "--rays", "200"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  std::string path_;
};

TEST_F(TraceMotionCommand, WritesAFolderOfResponsesAlongAPath) {
  const std::string folder = (folder_ / "responses").string();
  const std::vector<std::string> all = with(
      {"--source", "3,4,1.5", "--listener-path", path_, "--step", "0.25", "--mono", "-o", folder});
  const ProgramOutcome outcome = run_earpoint(all);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(read_text_file(fs::path(folder) / "index.csv"),
            "file,time_s,source_x,source_y,source_z,source_yaw_deg,source_pitch_deg,"
            "source_roll_deg,listener_x,listener_y,listener_z,listener_yaw_deg,listener_pitch_deg,"
            "listener_roll_deg\n"
            "00000.wav,0,3,4,1.5,0,0,0,5,2.5,1.5,0,0,0\n"
            "00001.wav,0.25,3,4,1.5,0,0,0,3,2.5,1.5,45,0,0\n"
            "00002.wav,0.5,3,4,1.5,0,0,0,1,2.5,1.5,90,0,0\n");
  // 2.5, 1.5 and 2.5 m at 343.2 m/s, to the nearest sample.
  const double distances_m[] = {2.5, 1.5, 2.5};
  for (int i = 0; i < 3; ++i) {
    const Waveform response = read_sound(fs::path(folder) / fmt::format("{:05}.wav", i));
    EXPECT_EQ(response.samples(), 3200);
    const std::span<const float> samples = response.channel(0);
    const auto peak = std::max_element(samples.begin(), samples.end()) - samples.begin();
    EXPECT_NEAR(static_cast<double>(peak), distances_m[i] / 343.2 * 16000, 1.0);
  }
  // A second run leaves the folder unchanged.
  const ProgramOutcome again = run_earpoint(all);
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_NE(again.errors.find("exists already"), std::string::npos) << again.errors;
}

TEST_F(TraceMotionCommand, PlaysASoundToAListenerWhoWalks) {
  const std::string sound = (folder_ / "dry.wav").string();
  Waveform dry(1, 8820, 22050);
  for (std::ptrdiff_t i = 0; i < dry.samples(); ++i) {
    dry.channel(0)[i] = 0.3F * std::sin(0.2F * static_cast<float>(i));
  }
  write_sound(sound, dry, SampleFormat::float32);
  const ProgramOutcome outcome = run_earpoint(
      with({"--source", "3,4,1.5", "--listener-path", path_, "--sound", sound, "-o", output_}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const Waveform heard = read_sound(output_);
  EXPECT_EQ(heard.channels(), 2);
  EXPECT_EQ(heard.sample_rate_hz(), 22050);
  EXPECT_EQ(heard.samples(), 8820 + 4410);
  EXPECT_GT(energy(heard.channel(0)), 0.0);
}

TEST_F(TraceMotionCommand, RefusesPathsThatLeaveTheSceneOrAreNotAlone) {
  const auto line = [&](const std::vector<std::string>& more) { return refusal(with(more)); };
  EXPECT_EQ(line({"--listener-path", path_, "-o", output_}),
            "earpoint: --source: is missing; give it or --source-path\n");
  EXPECT_EQ(
      line({"--source", "3,4,1.5", "--listener", "1,1,1", "--listener-path", path_, "-o", output_}),
      "earpoint: --listener-path: cannot be combined with --listener; give one of the two\n");
  write_file(path_, std::string_view("time_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n"
                                     "0,5,2.5,1.5,0,0,0\n1,5,6.5,1.5,0,0,0\n"));
  EXPECT_NE(line({"--source", "3,4,1.5", "--listener-path", path_, "-o", output_})
                .find("--listener-path: at 0.7 s: (5, 5.3, 1.5) is outside"),
            std::string::npos);
  EXPECT_NE(line({"--source", "3,4,1.5", "--listener-path", "none.csv", "-o", output_})
                .find("none.csv: no such file"),
            std::string::npos);
}

}  // namespace

}  // namespace earpoint
