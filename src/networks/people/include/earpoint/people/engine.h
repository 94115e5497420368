#pragma once

#include <memory>
#include <span>

#include <earpoint/core/resize.h>
#include <earpoint/people/description.h>
#include <earpoint/people/weights.h>

namespace earpoint {

/// Runs the network that finds people. One caller at a time.
class PeopleNetwork {
 public:
  /// @param threads  > 0
  explicit PeopleNetwork(PeopleWeights weights, int threads = 1);
  ~PeopleNetwork();
  PeopleNetwork(PeopleNetwork&&) noexcept;
  PeopleNetwork& operator=(PeopleNetwork&&) noexcept;

  [[nodiscard]] const PeopleDescription& description() const;

  /// The first view of a size lays the network out for it; later ones of that size allocate
  /// nothing.
  /// @param view  as people_view() makes it; both sides multiples of PeopleDescription::kCoarsest
  /// @return [PeopleDescription::kOutputs][height / kCell][width / kCell], valid until the next
  ///         call
  /// @throws std::logic_error if the view has another form
  [[nodiscard]] std::span<const float> run(const ImagePlanes& view);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
