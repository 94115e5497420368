#pragma once

#include <optional>

namespace earpoint {

/// Two-sided exact sign test: how likely a split at least as uneven as this is if both sides are
/// preferred equally often and all votes are independent.
/// @param wins, losses  >= 0
/// @return  in (0, 1]; 1 where there are no votes
[[nodiscard]] double sign_test_p(int wins, int losses);

/// How likely the test finds p < alpha where one side is truly preferred in that share of votes.
/// @param votes  >= 0, without ties
/// @param share  in [0, 1]
[[nodiscard]] double sign_test_power(int votes, double share, double alpha = 0.05);

/// The smallest true share above one half that the test finds with that power.
/// @return nothing if there are too few votes for any
[[nodiscard]] std::optional<double> detectable_share(int votes, double power = 0.8,
                                                     double alpha = 0.05);

}  // namespace earpoint
