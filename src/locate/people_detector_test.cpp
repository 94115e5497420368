#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/locate/people_detector.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

const fs::path kData = EARPOINT_SOURCE_DIR "/src/locate/testdata";

std::string refusal(const fs::path& file) {
  try {
    (void)make_people_detector(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(PeopleDetector, RefusesFilesThatAreNoDetectorByName) {
  EXPECT_NE(refusal(kData / "none.onnx").find("none.onnx"), std::string::npos);
  EXPECT_NE(refusal(kData / "make_detectors.py").find("expected nanodet"), std::string::npos);
  EXPECT_NE(
      refusal(EARPOINT_SOURCE_DIR "/models/rt60.safetensors").find("not a network that detects"),
      std::string::npos);
}

#if EARPOINT_HAS_OPENCV

/// Red 0.25, green 0.5, blue 0.75 of full scale.
Image coloured(int width, int height) {
  Image picture(width, height, 3);
  for (std::size_t i = 0; i < picture.pixels().size(); i += 3) {
    picture.pixels()[i] = 64;
    picture.pixels()[i + 1] = 128;
    picture.pixels()[i + 2] = 191;
  }
  return picture;
}

constexpr double kRed = 64.0 / 255.0;
constexpr double kGreen = 128.0 / 255.0;
constexpr double kBlue = 191.0 / 255.0;
constexpr double kRounding = 1e-5;  // float32's, of means over 4096 pixels

TEST(PeopleDetector, ShowsYoloV8RedGreenBlueFromZeroToOne) {
  const auto detector = make_people_detector(kData / "yolov8.onnx");
  EXPECT_EQ(detector->name(), "yolov8.onnx");
  const auto people = detector->detect(coloured(128, 128));
  ASSERT_EQ(people.size(), 1U);
  const Box& box = people[0].box;
  EXPECT_NEAR(0.5 * (box.y_min + box.y_max), kGreen, kRounding);
  EXPECT_NEAR(box.y_max - box.y_min, 0.5, kRounding);
  // The left edge is outside the picture: only the right one shows the middle and the width.
  EXPECT_NEAR(box.x_max, kRed + 0.5 * kBlue, kRounding);
  EXPECT_EQ(box.x_min, 0.0);
  EXPECT_NEAR(people[0].score, 0.9, 1e-6);
}

TEST(PeopleDetector, ShowsYoloXBlueGreenRedTo255) {
  const auto people = make_people_detector(kData / "yolox.onnx")->detect(coloured(64, 64));
  ASSERT_EQ(people.size(), 1U);
  const Box& box = people[0].box;
  constexpr double kCell = 16.0 / 64.0;
  EXPECT_NEAR(box.y_max, kCell * (kGreen + 0.5), kRounding);
  EXPECT_NEAR(box.x_max, kCell * (kBlue + 0.5 * std::exp(kRed)), kRounding);
  EXPECT_NEAR(people[0].score, 0.6, 1e-6);
}

TEST(PeopleDetector, PutsOblongPicturesIntoTheMiddleOfWhatYoloV8Sees) {
  const auto people = make_people_detector(kData / "yolov8.onnx")->detect(coloured(128, 64));
  ASSERT_EQ(people.size(), 1U);
  // Half of its input is picture, half is grey.
  constexpr double kGrey = 114.0 / 255.0;
  const double green = 0.5 * (kGreen + kGrey);
  const double red_middle = 0.5 * (kRed + kGrey);
  const double blue_width = 0.5 * (kBlue + kGrey);
  constexpr double kOblongRounding = 1e-4;  // float32 means of pixels that differ
  const Box& box = people[0].box;
  // The picture begins at 16 pixels of 64 and has 32; the box is 32 high.
  EXPECT_NEAR(box.y_max, (64 * green + 16 - 16) / 32, kOblongRounding);
  EXPECT_EQ(box.y_min, 0.0);
  EXPECT_NEAR(box.x_max, red_middle + 0.5 * blue_width, kOblongRounding);
}

TEST(PeopleDetector, SaysWhatOpenCvCannotRun) {
  const fs::path cut = fs::path(testing::TempDir()) / "cut.onnx";
  std::vector<std::byte> bytes = read_file(kData / "yolov8.onnx");
  bytes.resize(bytes.size() - 10);
  write_file(cut, bytes);
  EXPECT_NE(refusal(cut).find("cut.onnx"), std::string::npos);
  fs::remove(cut);
}

#else

TEST(PeopleDetector, SaysThatOnnxFilesNeedOpenCv) {
  EXPECT_NE(refusal(kData / "yolov8.onnx").find("needs OpenCV"), std::string::npos);
}

#endif

}  // namespace
}  // namespace earpoint
