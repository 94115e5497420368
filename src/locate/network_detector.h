#pragma once

#include <string>
#include <vector>

#include <earpoint/locate/people_detector.h>
#include <earpoint/people/engine.h>
#include <earpoint/people/weights.h>

namespace earpoint {

/// The project's own network.
class NetworkDetector : public PeopleDetector {
 public:
  /// @param name  what name() says
  NetworkDetector(PeopleWeights weights, std::string name, int threads);

  [[nodiscard]] std::vector<DetectedPerson> detect(const Image& picture) override;
  [[nodiscard]] std::string name() const override { return name_; }

 private:
  PeopleNetwork network_;
  std::string name_;
};

}  // namespace earpoint
