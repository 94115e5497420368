// How well a detector finds people in pictures with known people, and its processor time per
// picture. Writes one JSON object to standard output.
//
// usage: people_detection DATA [SPLIT [DETECTOR]]     default: the test split and the shipped
// detector
//
// DATA is what earpoint-people-pictures or earpoint simulate wrote. A person counts as found where
// the boxes overlap by half (intersection over union). For "unoccluded", people who are partly
// hidden or of unknown visibility need not be found; for "all", everybody who is listed.

#include <array>
#include <cstdio>
#include <ctime>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <earpoint/dataset/people_pictures.h>
#include <earpoint/error.h>
#include <earpoint/locate/detection_count.h>
#include <earpoint/locate/people_detector.h>
#include <earpoint/media/image_file.h>

namespace {

using namespace earpoint;
using Json = nlohmann::ordered_json;

constexpr double kUnoccluded = 0.9;
/// Heights of boxes as shares of the picture's.
constexpr std::array kHeights{0.0, 0.125, 0.25, 0.5, 1.01};

double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

bool is_unoccluded(const LabelledPerson& person) {
  return person.visible && *person.visible >= kUnoccluded;
}

/// @param must_be_found  of each person
template <typename MustBeFound>
DetectionCount count(const std::vector<DetectedPerson>& found, const PeoplePicture& picture,
                     MustBeFound must_be_found) {
  std::vector<TruePerson> people;
  for (const LabelledPerson& person : picture.people) {
    people.push_back({person.box, must_be_found(person)});
  }
  return count_detections(found, people);
}

Json json_of(const DetectionCount& count) {
  return {{"people", count.found + count.missed},
          {"found", count.found},
          {"wrong", count.wrong},
          {"recall", count.recall()},
          {"precision", count.precision()}};
}

void measure(const std::string& data, const std::string& split, PeopleDetector& detector) {
  const std::vector<PeoplePicture> pictures = read_people_pictures(data, split);
  DetectionCount unoccluded;
  DetectionCount all;
  std::array<DetectionCount, kHeights.size() - 1> by_height;
  double seconds = 0.0;
  for (const PeoplePicture& labels : pictures) {
    const Image picture = read_image(labels.file);
    const double start_s = processor_seconds();
    const std::vector<DetectedPerson> found = detector.detect(picture);
    seconds += processor_seconds() - start_s;
    unoccluded += count(found, labels, is_unoccluded);
    all += count(found, labels, [](const LabelledPerson&) { return true; });
    for (std::size_t i = 0; i < by_height.size(); ++i) {
      by_height[i] += count(found, labels, [&](const LabelledPerson& person) {
        const double height = person.box.y_max - person.box.y_min;
        return is_unoccluded(person) && height >= kHeights[i] && height < kHeights[i + 1];
      });
    }
  }
  Json heights = Json::array();
  for (std::size_t i = 0; i < by_height.size(); ++i) {
    heights.push_back({{"from", kHeights[i]},
                       {"people", by_height[i].found + by_height[i].missed},
                       {"recall", by_height[i].recall()}});
  }
  const auto count_of = static_cast<double>(pictures.size());
  fmt::print("{}\n", Json{{"detector", detector.name()},
                          {"split", split},
                          {"pictures", pictures.size()},
                          {"unoccluded", json_of(unoccluded)},
                          {"all", json_of(all)},
                          {"by_height", heights},
                          {"processor_ms_per_picture", 1000.0 * seconds / count_of}}
                         .dump(2));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    fmt::print(stderr, "usage: people_detection DATA [SPLIT [DETECTOR]]\n");
    return 2;
  }
  try {
    std::optional<std::filesystem::path> file;
    if (argc > 3) file = argv[3];
    const std::unique_ptr<PeopleDetector> detector = make_people_detector(file);
    measure(argv[1], argc > 2 ? argv[2] : "test", *detector);
  } catch (const std::exception& error) {
    fmt::print(stderr, "people_detection: {}\n", error.what());
    return 1;
  }
  return 0;
}
