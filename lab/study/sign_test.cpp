#include <algorithm>
#include <cmath>

#include <earpoint/error.h>
#include <earpoint/study/sign_test.h>

namespace earpoint {
namespace {

/// P(X = k) of Binomial(n, share).
double binomial(int n, int k, double share) {
  if (share <= 0.0) return k == 0 ? 1.0 : 0.0;
  if (share >= 1.0) return k == n ? 1.0 : 0.0;
  return std::exp(std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0) +
                  k * std::log(share) + (n - k) * std::log1p(-share));
}

/// P(X <= k)
double at_most(int n, int k, double share) {
  double sum = 0.0;
  for (int i = 0; i <= k; ++i) sum += binomial(n, i, share);
  return std::min(sum, 1.0);
}

}  // namespace

double sign_test_p(int wins, int losses) {
  EARPOINT_CHECK(wins >= 0 && losses >= 0);
  return std::min(1.0, 2.0 * at_most(wins + losses, std::min(wins, losses), 0.5));
}

double sign_test_power(int votes, double share, double alpha) {
  EARPOINT_CHECK(votes >= 0 && share >= 0.0 && share <= 1.0);
  // Splits up to this one are found to be uneven.
  int critical = -1;
  while (critical + 1 <= votes / 2 && sign_test_p(critical + 1, votes - critical - 1) < alpha) {
    ++critical;
  }
  if (critical < 0) return 0.0;
  return at_most(votes, critical, share) + at_most(votes, critical, 1.0 - share);
}

std::optional<double> detectable_share(int votes, double power, double alpha) {
  if (sign_test_power(votes, 1.0, alpha) < power) return std::nullopt;
  double low = 0.5;
  double high = 1.0;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (sign_test_power(votes, middle, alpha) < power ? low : high) = middle;
  }
  return high;
}

}  // namespace earpoint
