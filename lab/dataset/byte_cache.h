#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

namespace earpoint {

/// What was read, by file, as long as all of it together stays within so many bytes: what was used
/// longest ago leaves first. Any thread may ask at any time; whoever holds a value keeps it alive.
class ByteCache {
 public:
  explicit ByteCache(std::size_t capacity_bytes) : capacity_bytes_(capacity_bytes) {}

  /// The value of that key, made by `load` if it is not there. Two threads that miss at once both
  /// load, and both get the first one's.
  /// @param key       of a value of this type, always
  /// @param load      returns a Value
  /// @param bytes_of  how many bytes a Value holds
  template <typename Value, typename Load, typename BytesOf>
  std::shared_ptr<const Value> get(const std::string& key, Load&& load, BytesOf&& bytes_of) {
    if (const auto found = find(key)) return std::static_pointer_cast<const Value>(found);
    auto value = std::make_shared<const Value>(load());
    const std::size_t bytes = bytes_of(*value);
    return std::static_pointer_cast<const Value>(keep(key, std::move(value), bytes));
  }

 private:
  struct Entry {
    std::string key;
    std::shared_ptr<const void> value;
    std::size_t bytes = 0;
  };

  std::shared_ptr<const void> find(const std::string& key) {
    const std::lock_guard lock(mutex_);
    const auto found = by_key_.find(key);
    if (found == by_key_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, found->second);
    return found->second->value;
  }

  std::shared_ptr<const void> keep(const std::string& key, std::shared_ptr<const void> value,
                                   std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    if (const auto found = by_key_.find(key); found != by_key_.end()) return found->second->value;
    if (bytes > capacity_bytes_) return value;
    entries_.push_front({key, value, bytes});
    by_key_[key] = entries_.begin();
    bytes_ += bytes;
    while (bytes_ > capacity_bytes_) {
      bytes_ -= entries_.back().bytes;
      by_key_.erase(entries_.back().key);
      entries_.pop_back();
    }
    return value;
  }

  std::mutex mutex_;
  std::size_t capacity_bytes_;
  std::size_t bytes_ = 0;
  std::list<Entry> entries_;  // last used first
  std::map<std::string, std::list<Entry>::iterator> by_key_;
};

}  // namespace earpoint
