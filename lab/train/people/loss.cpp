#include "loss.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/log_sigmoid.h>
#include <ATen/ops/maximum.h>
#include <ATen/ops/minimum.h>
#include <ATen/ops/sigmoid.h>
#include <ATen/ops/stack.h>

#include <earpoint/people/description.h>

namespace earpoint {
namespace {

using D = PeopleDescription;

constexpr double kBoxLoss = 2.0;  // beside the loss of middles

at::Tensor focal_loss(const at::Tensor& logit, const PeopleTargets& targets) {
  const at::Tensor sure = at::sigmoid(logit);
  const at::Tensor is_middle = targets.middles.eq(1.0).to(logit.scalar_type());
  const at::Tensor found = at::log_sigmoid(logit) * (1.0 - sure).square() * is_middle;
  const at::Tensor left = at::log_sigmoid(-logit) * sure.square() * (1.0 - targets.middles).pow(4) *
                          targets.background * (1.0 - is_middle);
  return -(found + left).sum() / is_middle.sum().clamp_min(1.0);
}

at::Tensor area(const at::Tensor& boxes) {
  return (boxes.select(1, 2) - boxes.select(1, 0)).clamp_min(0.0) *
         (boxes.select(1, 3) - boxes.select(1, 1)).clamp_min(0.0);
}

at::Tensor box_loss(const at::Tensor& answer, const PeopleTargets& targets) {
  const at::Tensor ours = boxes_of_cells(answer);
  const at::Tensor& theirs = targets.boxes;
  const auto joined = [&](bool is_inner) {
    const at::Tensor low = is_inner ? at::maximum(ours, theirs) : at::minimum(ours, theirs);
    const at::Tensor high = is_inner ? at::minimum(ours, theirs) : at::maximum(ours, theirs);
    return at::stack({low.select(1, 0), low.select(1, 1), high.select(1, 2), high.select(1, 3)}, 1);
  };
  const at::Tensor shared = area(joined(true));
  const at::Tensor covered = area(ours) + area(theirs) - shared;
  const at::Tensor hull = area(joined(false)).clamp_min(1.0);
  const at::Tensor overlap = shared / covered.clamp_min(1.0) - (hull - covered) / hull;
  return ((1.0 - overlap) * targets.weights).sum() / targets.weights.sum().clamp_min(1.0);
}

}  // namespace

at::Tensor boxes_of_cells(const at::Tensor& answer) {
  const auto middles = [&](std::int64_t axis) {
    return at::arange(answer.size(axis), answer.options()) + 0.5;
  };
  const at::Tensor x = (answer.select(1, 1) + middles(3)) * D::kCell;
  const at::Tensor y = (answer.select(1, 2) + middles(2).unsqueeze(1)) * D::kCell;
  const auto half = [&](std::int64_t output) {
    return answer.select(1, output).clamp(-D::kLargestLog, D::kLargestLog).exp() *
           (0.5 * D::kBoxUnit);
  };
  const at::Tensor half_width = half(3);
  const at::Tensor half_height = half(4);
  return at::stack({x - half_width, y - half_height, x + half_width, y + half_height}, 1);
}

at::Tensor people_loss(const at::Tensor& answer, const PeopleTargets& targets) {
  return focal_loss(answer.select(1, 0), targets) + kBoxLoss * box_loss(answer, targets);
}

}  // namespace earpoint
