#include <filesystem>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/dataset/people_pictures.h>
#include <earpoint/generate/people_pictures.h>
#include <earpoint/generate_testing/quick_generation.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

std::map<std::string, std::vector<std::byte>> files_of(const fs::path& folder) {
  std::map<std::string, std::vector<std::byte>> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    files[fs::relative(entry.path(), folder).string()] = read_file(entry.path());
  }
  return files;
}

void draw(const fs::path& out, int jobs) {
  draw_people_pictures({.out = out,
                        .seed = 3,
                        .train_homes = 1,
                        .val_homes = 1,
                        .test_homes = 1,
                        .groups = 1,
                        .views = 2,
                        .width = 96,
                        .height = 64,
                        .split = {},
                        .jobs = jobs},
                       FurnitureLibrary(), FigureLibrary(), [](int, int) {});
}

TEST(PeoplePictures, AreTheSameForAnyNumberOfJobsAndAfterAKill) {
  const TestFolder folder("people_pictures_test");
  draw(folder.path() / "one", 1);
  const auto files = files_of(folder.path() / "one");
  EXPECT_GE(files.size(), 3U);
  draw(folder.path() / "two", 2);
  EXPECT_EQ(files_of(folder.path() / "two"), files);
  // A home whose list is missing is made again.
  fs::remove(folder.path() / "two/val/home-0001/people.json");
  draw(folder.path() / "two", 1);
  EXPECT_EQ(files_of(folder.path() / "two"), files);
  for (const std::string split : {"train", "val", "test"}) {
    for (const PeoplePicture& picture : read_people_pictures(folder.path() / "one", split)) {
      EXPECT_TRUE(fs::exists(picture.file));
      for (const LabelledPerson& person : picture.people) EXPECT_GE(*person.visible, 0.15);
    }
  }
}

TEST(VariedFigure, KeepsSkinAndChangesClothesAndSize) {
  FigureModel figure;
  figure.mouth_m = {0.1, 0.0, 1.5};
  figure.scene.mesh.positions = {{0.0F, 0.0F, 0.0F}, {0.3F, 0.2F, 1.7F}};
  figure.scene.textures = {Image(2, 1, 3)};
  const std::array<std::uint8_t, 6> pixels{200, 150, 120, 20, 60, 180};  // skin, a blue shirt
  std::copy(pixels.begin(), pixels.end(), figure.scene.textures[0].pixels().begin());
  RandomStream random(5);
  const FigureModel varied = varied_figure(figure, random);
  const auto changed = varied.scene.textures[0].pixels();
  EXPECT_TRUE(std::equal(pixels.begin(), pixels.begin() + 3, changed.begin()));
  EXPECT_FALSE(std::equal(pixels.begin() + 3, pixels.end(), changed.begin() + 3));
  const float scale = varied.scene.mesh.positions[1][2] / 1.7F;
  EXPECT_GE(scale, 0.9F);
  EXPECT_LE(scale, 1.1F);
  EXPECT_NEAR(varied.mouth_m.z, 1.5 * scale, 1e-6);  // float32's rounding of the scale
}

}  // namespace
}  // namespace earpoint
