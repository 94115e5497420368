#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/core/file.h>
#include <earpoint/dataset/people_pictures.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

std::string refusal(const std::string& pictures) {
  try {
    (void)parse_people_pictures(R"({"format":"earpoint-people-1","pictures":)" + pictures + "}",
                                "list", "folder");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(PeoplePictures, ListReadsBack) {
  const Box box{.x_min = 0.125, .y_min = 0.25, .x_max = 0.5, .y_max = 1.0};
  const std::vector<PeoplePicture> pictures{{"elsewhere/a.jpg", {{box, 0.75}}}, {"b.png", {}}};
  const auto read = parse_people_pictures(people_picture_list(pictures), "list", "folder");
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0].file, fs::path("folder/a.jpg"));
  ASSERT_EQ(read[0].people.size(), 1U);
  EXPECT_EQ(read[0].people[0].box, box);
  EXPECT_EQ(read[0].people[0].visible, 0.75);
  EXPECT_TRUE(read[1].people.empty());
}

TEST(PeoplePictures, NamesWhatIsWrongWithAList) {
  const auto of_person = [](const std::string& person) {
    return refusal(R"([{"file":"a.jpg","people":[)" + person + "]}]");
  };
  EXPECT_EQ(of_person(R"({"box":[0,0,1,1],"visible":1})"), "accepted");
  EXPECT_NE(of_person(R"({"box":[0,0,1],"visible":1})").find("expected 4 numbers"),
            std::string::npos);
  EXPECT_NE(of_person(R"({"box":[0,0,1.5,1],"visible":1})").find("expected 0 to 1, found 1.5"),
            std::string::npos);
  EXPECT_NE(of_person(R"({"box":[0.5,0,0.5,1],"visible":1})").find("x_min < x_max"),
            std::string::npos);
  EXPECT_NE(of_person(R"({"box":[0,0,1,1]})").find("visible"), std::string::npos);
  EXPECT_NE(refusal(R"([{"file":"../a.jpg","people":[]}])").find("same folder"), std::string::npos);
  EXPECT_THROW((void)parse_people_pictures("{", "list", ""), InputError);
}

TEST(PeoplePictures, ReadsListsAndViewsOfConversationsOfASplit) {
  const fs::path data = fs::path(testing::TempDir()) / ("people." + std::to_string(::getpid()));
  fs::remove_all(data);
  fs::create_directories(data / "train/home-0000");
  write_file(data / "train/home-0000/people.json",
             R"({"format":"earpoint-people-1","pictures":[{"file":"a.jpg","people":[]}]})");
  fs::create_directories(data / "other/home-0001/0");
  write_file(data / "other/home-0001/0/clip.json",
             R"([{"viewpoints":[
                  {"location":[0,1.5,0],"rotation":0,"rir":{"0":"a.wav"},
                   "image":"train/home-0001/0/view_0.png",
                   "bboxes":{"0":[0,0,0,0],"1":[64,127,0,63]}},
                  {"location":[1,1.5,0],"rotation":0,"rir":{"0":"b.wav"},
                   "image":"train/home-0001/0/view_1.png","bboxes":{}}],
                  "speakers":[{"id":0,"speech":null,"location":[1,1.5,1]}]}])");
  fs::create_directory_symlink(data / "other", data / "train/joined");
  const auto pictures = read_people_pictures(data, "train");
  ASSERT_EQ(pictures.size(), 3U);
  EXPECT_EQ(pictures[0].file, data / "train/home-0000/a.jpg");
  EXPECT_EQ(pictures[1].file, data / "train/joined/home-0001/0/view_0.png");
  ASSERT_EQ(pictures[1].people.size(), 1U);
  EXPECT_EQ(pictures[1].people[0].box,
            (Box{.x_min = 0.0, .y_min = 0.25, .x_max = 0.25, .y_max = 0.5}));
  EXPECT_FALSE(pictures[1].people[0].visible.has_value());
  EXPECT_THROW((void)read_people_pictures(data, "val"), InputError);
  fs::remove_all(data);
}

}  // namespace
}  // namespace earpoint
