#include <earpoint/generate/work_plan.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

// The paper's scenes.
constexpr int kVal = 10;
constexpr int kTest = 20;
constexpr int kAll = 120;

/// Numbers of val and test items out of `count`; the rest is train.
std::array<int, 2> held_out(int count) {
  if (count < 2) return {0, 0};
  const auto part = [&](int share) {
    return std::max(1, static_cast<int>(std::lround(static_cast<double>(count) * share / kAll)));
  };
  if (count == 2) return {0, 1};
  return {part(kVal), part(kTest)};
}

DataSplit split_of(int index, int count) {
  const auto [val, test] = held_out(count);
  if (index >= count - test) return DataSplit::test;
  if (index >= count - test - val) return DataSplit::val;
  return DataSplit::train;
}

}  // namespace

Shard parse_shard(std::string_view text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto [slash, index_error] = std::from_chars(text.data(), end, shard.index);
  if (index_error == std::errc() && slash != end && *slash == '/') {
    const auto [last, count_error] = std::from_chars(slash + 1, end, shard.count);
    if (count_error == std::errc() && last == end && shard.index >= 0 &&
        shard.index < shard.count) {
      return shard;
    }
  }
  throw InputError("shard",
                   fmt::format("expected i/n with i from 0 to n - 1, like 0/8, found '{}'", text));
}

DataSplit voices_of_split(std::string_view split) {
  if (split == "train") return DataSplit::train;
  return split.starts_with("val") ? DataSplit::val : DataSplit::test;
}

std::vector<WorkItem> plan_work(const WorkOrder& order) {
  EARPOINT_CHECK(order.scenes > 0 && order.conversations > 0);
  std::vector<WorkItem> items;
  for (int scene = 0; scene < order.scenes; ++scene) {
    std::map<std::string, int> folders;
    for (int conversation = 0; conversation < order.conversations; ++conversation) {
      const DataSplit part = order.scenes == 1 ? split_of(conversation, order.conversations)
                                               : split_of(scene, order.scenes);
      WorkItem item{.scene = scene, .conversation = conversation, .split = {}};
      item.split = order.split.value_or(std::string(name_of(part)));
      item.voices = order.split ? voices_of_split(*order.split) : part;
      item.folder = folders[item.split]++;
      items.push_back(std::move(item));
    }
  }
  return items;
}

std::vector<WorkItem> items_of_shard(const std::vector<WorkItem>& items, const WorkOrder& order,
                                     const Shard& shard) {
  EARPOINT_CHECK(shard.count > 0 && shard.index >= 0 && shard.index < shard.count);
  const bool by_scene = order.scenes >= shard.count;
  std::vector<WorkItem> mine;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const int number = by_scene ? items[i].scene : static_cast<int>(i);
    if (number % shard.count == shard.index) mine.push_back(items[i]);
  }
  return mine;
}

}  // namespace earpoint
