#include "network_detector.h"

#include <utility>

#include <earpoint/error.h>
#include <earpoint/locate/decode_people.h>
#include <earpoint/people/description.h>
#include <earpoint/people/view.h>
#include <earpoint/people/weights.h>

namespace earpoint {

NetworkDetector::NetworkDetector(PeopleWeights weights, std::string name, int threads)
    : network_(std::move(weights), threads), name_(std::move(name)) {}

std::vector<DetectedPerson> NetworkDetector::detect(const Image& picture) {
  EARPOINT_CHECK(!picture.empty() && picture.channels() == 3);
  const ImagePlanes view = people_view(picture, network_.description().longest_px);
  return decode_people(network_.run(view), view.height / PeopleDescription::kCell,
                       view.width / PeopleDescription::kCell);
}

}  // namespace earpoint
