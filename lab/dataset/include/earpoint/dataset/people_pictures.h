#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/image.h>

namespace earpoint {

/// The file that lists the pictures of one home.
inline constexpr std::string_view kPeoplePictureList = "people.json";

/// A person in a picture whose place is known.
struct LabelledPerson {
  Box box;  ///< around what is seen of the person
  /// Share of the person within the picture that nothing hides, 0 to 1; nothing where the data set
  /// does not tell.
  std::optional<double> visible;
};

/// A picture with everybody in it.
struct PeoplePicture {
  std::filesystem::path file;
  std::vector<LabelledPerson> people;
};

/// The pictures of a split, in the order of their names: those that `earpoint-people-pictures`
/// wrote (docs/formats.md has the layout), or the views of a data set of `earpoint simulate`.
/// @param data   the data set's folder
/// @param split  train, val or test
/// @throws InputError if there is no picture, or a list is malformed
[[nodiscard]] std::vector<PeoplePicture> read_people_pictures(const std::filesystem::path& data,
                                                              const std::string& split);

/// Reads one list. @param where  its file, for messages. @param folder  the pictures lie there
/// @throws InputError naming the field that is missing or malformed
[[nodiscard]] std::vector<PeoplePicture> parse_people_pictures(std::string_view json,
                                                               const std::string& where,
                                                               const std::filesystem::path& folder);

/// Writes it; of the pictures' paths only the names are kept.
[[nodiscard]] std::string people_picture_list(std::span<const PeoplePicture> pictures);

}  // namespace earpoint
