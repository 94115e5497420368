#include <earpoint/train/network_learner.h>

#include "graph_tensors.h"
#include "learned_tensors.h"
#include "torch_tensor.h"

#include <earpoint/error.h>

namespace earpoint {

GradientLearner::GradientLearner() = default;
GradientLearner::~GradientLearner() = default;
GradientLearner::GradientLearner(GradientLearner&&) noexcept = default;
GradientLearner& GradientLearner::operator=(GradientLearner&&) noexcept = default;

void GradientLearner::set_tensors(LearnedTensors tensors) {
  EARPOINT_CHECK(learned_ == nullptr);
  learned_ = std::make_unique<LearnedTensors>(std::move(tensors));
}

void GradientLearner::forget_gradients() { earpoint::forget_gradients(learned_->parameters); }

void GradientLearner::resume_optimizer(const SafetensorsFile& file, std::string_view where) {
  learned_->adam.load(file, where);
}

std::map<std::string, Tensor> GradientLearner::tensors() const {
  std::map<std::string, Tensor> all = learned_->network.weights();
  for (const auto& [name, table] : learned_->tables) all[name] = from_torch(table);
  return all;
}

std::map<std::string, Tensor> GradientLearner::gradients() const {
  return learned_->network.gradients();
}

void GradientLearner::visit_gradients(const Visitor& visitor) {
  earpoint::visit_gradients(learned_->parameters, visitor);
}

void GradientLearner::visit_statistics(const Visitor& visitor) {
  visit_values(learned_->network.buffers, visitor);
}

void GradientLearner::apply_gradients(double learning_rate) {
  if (learned_->longest_gradient) clip_gradients(learned_->parameters, *learned_->longest_gradient);
  learned_->adam.step(learning_rate);
}

std::int64_t GradientLearner::steps() const { return learned_->adam.steps(); }

SafetensorsFile GradientLearner::checkpoint() const {
  SafetensorsFile file = weight_file();
  learned_->adam.save(file);
  return file;
}

}  // namespace earpoint
