#include "dataset_lock.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

const fs::path& made(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(folder.string(), "cannot be created: " + error.message());
  return folder;
}

}  // namespace

DatasetLock::DatasetLock(const fs::path& folder, const WorkOrder& order)
    : folder_(folder), conversations_(order.conversations), ranges_(made(folder) / kFile) {}

void DatasetLock::take(const std::vector<WorkItem>& items) {
  std::vector<std::int64_t> numbers;
  numbers.reserve(items.size());
  for (const WorkItem& item : items) {
    numbers.push_back(kFirstItem + item.scene * conversations_ + item.conversation);
  }
  std::ranges::sort(numbers);
  // Neighbours in one request.
  for (std::size_t i = 0; i < numbers.size();) {
    std::size_t end = i + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    if (!ranges_.try_lock(numbers[i], static_cast<std::int64_t>(end - i))) {
      throw InputError(folder_.string(),
                       "another process is simulating the same part of this data set",
                       "wait for it, or give each process its own shard i/n");
    }
    i = end;
  }
}

}  // namespace earpoint
