#include "dataset_lock.h"

#include <algorithm>

#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {

namespace fs = std::filesystem;

DatasetLock::DatasetLock(const fs::path& folder, const WorkOrder& order)
    : folder_(folder),
      conversations_(order.conversations),
      ranges_(create_folder(folder) / kFile) {}

void DatasetLock::take(const std::vector<WorkItem>& items) {
  std::vector<std::int64_t> numbers;
  numbers.reserve(items.size());
  for (const WorkItem& item : items) {
    numbers.push_back(kFirstItem + item.scene * conversations_ + item.conversation);
  }
  std::ranges::sort(numbers);
  // Consecutive numbers are locked by one call.
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
