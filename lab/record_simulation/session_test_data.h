#pragma once

#include <memory>
#include <vector>

#include <earpoint/generate/conversation.h>
#include <earpoint/record_simulation/session_plan.h>

namespace earpoint {

/// An empty room of 6 x 5 x 2.7 m.
/// @param absorption  0.99 leaves little but the direct sound
std::shared_ptr<const PreparedScene> test_room(double absorption);

/// Two people who stand 1 m to either side of (3, 2.5), one camera at (1, 2.5) that looks along x
/// and one at (3, 4.5) that looks back at them; nobody walks or speaks; all clocks are right.
/// @param figures  must outlive the plan
SessionPlan plan_of_two(const FigureLibrary& figures);

}  // namespace earpoint
