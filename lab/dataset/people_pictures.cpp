#include <earpoint/dataset/people_pictures.h>

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/core/json_field.h>
#include <earpoint/core/json_file.h>
#include <earpoint/dataset/soundspaces_metadata.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::string_view kFormat = "earpoint-people-1";
constexpr std::string_view kConversation = "clip.json";

double share(const JsonField& json) {
  const double value = json.number();
  if (value >= 0.0 && value <= 1.0) return value;
  throw InputError(json.where(), fmt::format("expected 0 to 1, found {:g}", value));
}

Box box_of(const JsonField& json) {
  const std::vector<JsonField> edges = json.items();
  if (edges.size() != 4) {
    throw InputError(json.where(), fmt::format("expected 4 numbers, found {}", edges.size()));
  }
  const Box box{.x_min = share(edges[0]),
                .y_min = share(edges[1]),
                .x_max = share(edges[2]),
                .y_max = share(edges[3])};
  if (box.x_min < box.x_max && box.y_min < box.y_max) return box;
  throw InputError(json.where(), "expected x_min < x_max and y_min < y_max");
}

/// The views of one conversation.
void add_views(const fs::path& list, std::vector<PeoplePicture>& pictures) {
  for (const SoundSpacesClip& clip :
       parse_soundspaces_metadata(read_text_file(list), list.string(), "")) {
    for (const SoundSpacesViewpoint& viewpoint : clip.viewpoints) {
      PeoplePicture& picture = pictures.emplace_back();
      picture.file = list.parent_path() / fs::path(viewpoint.image).filename();
      for (const auto& [id, edges] : viewpoint.bboxes) {
        if (const auto box = from_soundspaces_box(edges)) picture.people.push_back({*box, {}});
      }
    }
  }
}

std::vector<fs::path> lists_below(const fs::path& folder) {
  std::vector<fs::path> lists;
  std::error_code missing;
  constexpr auto kFollow = fs::directory_options::follow_directory_symlink;
  for (fs::recursive_directory_iterator it(folder, kFollow, missing), end; it != end;
       it.increment(missing)) {
    const std::string name = it->path().filename().string();
    if (name == kPeoplePictureList || name == kConversation) lists.push_back(it->path());
  }
  std::ranges::sort(lists);
  return lists;
}

}  // namespace

std::vector<PeoplePicture> read_people_pictures(const fs::path& data, const std::string& split) {
  std::vector<PeoplePicture> pictures;
  for (const fs::path& list : lists_below(data / split)) {
    if (list.filename() == kConversation) {
      add_views(list, pictures);
      continue;
    }
    for (PeoplePicture& picture :
         parse_people_pictures(read_text_file(list), list.string(), list.parent_path())) {
      pictures.push_back(std::move(picture));
    }
  }
  if (!pictures.empty()) return pictures;
  throw InputError((data / split).string(), "holds no pictures of people",
                   "make some with earpoint-people-pictures or earpoint simulate");
}

std::vector<PeoplePicture> parse_people_pictures(std::string_view text, const std::string& where,
                                                 const fs::path& folder) {
  const nlohmann::json document = parse_json(text, where);
  const JsonField json(document, where);
  const JsonField format = json.field("format");
  if (format.text() != kFormat) {
    throw InputError(format.where(), fmt::format("expected \"{}\"", kFormat));
  }
  std::vector<PeoplePicture> pictures;
  for (const JsonField& item : json.field("pictures").items()) {
    PeoplePicture& picture = pictures.emplace_back();
    const JsonField file = item.field("file");
    const fs::path name = file.text();
    if (name.empty() || name != name.filename() || name == "..") {
      throw InputError(file.where(), "expected the name of a file in the same folder");
    }
    picture.file = folder / name;
    for (const JsonField& person : item.field("people").items()) {
      picture.people.push_back({box_of(person.field("box")), share(person.field("visible"))});
    }
  }
  return pictures;
}

std::string people_picture_list(std::span<const PeoplePicture> pictures) {
  Json list = Json::array();
  for (const PeoplePicture& picture : pictures) {
    Json people = Json::array();
    for (const LabelledPerson& person : picture.people) {
      const Box& b = person.box;
      people.push_back({{"box", std::array{b.x_min, b.y_min, b.x_max, b.y_max}},
                        {"visible", person.visible.value_or(1.0)}});
    }
    list.push_back({{"file", picture.file.filename().string()}, {"people", std::move(people)}});
  }
  return Json{{"format", kFormat}, {"pictures", std::move(list)}}.dump(1) + "\n";
}

}  // namespace earpoint
