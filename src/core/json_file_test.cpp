#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/core/json_field.h>
#include <earpoint/core/json_file.h>
#include <earpoint/core/temporary_folder.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

/// A list in a list, and so on.
std::string nested(int depth) {
  const auto count = static_cast<std::size_t>(depth);
  return std::string(count, '[') + std::string(count, ']');
}

std::string refusal(const std::string& text) {
  try {
    static_cast<void>(parse_json(text, "a.json"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(JsonFile, ReadsAFileAndNamesABadOne) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "a.json";
  write_file(path, std::string_view(R"({"b": [1, 2], "a": "ä"})"));
  EXPECT_EQ(read_json(path), nlohmann::json({{"a", "ä"}, {"b", {1, 2}}}));
  EXPECT_EQ(read_ordered_json(path).dump(), R"({"b":[1,2],"a":"ä"})");
  write_file(path, std::string_view("{"));
  EXPECT_THROW(static_cast<void>(read_json(path)), InputError);
  EXPECT_THROW(static_cast<void>(read_ordered_json(path)), InputError);
  EXPECT_THROW(static_cast<void>(read_json(folder.path() / "none.json")), InputError);
}

TEST(JsonFile, RefusesWhatIsNotJsonOrNestedTooDeeply) {
  EXPECT_EQ(refusal("[1,"), "a.json: is not valid JSON");
  EXPECT_EQ(refusal(nested(64)), "accepted");
  EXPECT_EQ(refusal(nested(65)), "a.json: is nested too deeply");
  EXPECT_EQ(refusal(nested(1'000'000)), "a.json: is nested too deeply");
  // Brackets in texts open nothing, and side by side they are not inside each other.
  EXPECT_EQ(refusal("[\"" + std::string(1000, '[') + "\\\"" + std::string(1000, '{') + "\"]"),
            "accepted");
  std::string flat = "[[]";
  for (int i = 0; i < 1000; ++i) flat += ",[]";
  EXPECT_EQ(refusal(flat + "]"), "accepted");
}

TEST(JsonField, ShowsTheBeginningOfWhatItFoundHoweverDeepItIs) {
  const auto message = [](const nlohmann::json& value) {
    try {
      static_cast<void>(JsonField(value, "a.json", "name").text());
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const std::string expected = "a.json: name: expected a text, found ";
  EXPECT_EQ(message({{"b", {1, 2.5, nullptr}}, {"a\"", "x\n"}, {"c", nlohmann::json::array()}}),
            expected + R"({"a\"":"x\n","b":[1,2.5,null],"c":[]})");
  std::string sevens;
  for (int i = 0; i < 29; ++i) sevens += ",7";  // 60 bytes with the first
  EXPECT_EQ(message(std::vector<int>(50, 7)), expected + "[7" + sevens + "...");
  // A walk to the end of this would take more than the stack has.
  EXPECT_EQ(message(nlohmann::json::parse(nested(1'000'000))),
            expected + std::string(60, '[') + "...");
}

}  // namespace
}  // namespace earpoint
