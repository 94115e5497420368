#pragma once

namespace earpoint {

/// Counts what all threads of the test program allocate while it lives: every call of malloc and
/// its kin, and so of operator new.
class AllocationCount {
 public:
  AllocationCount();
  ~AllocationCount();
  AllocationCount(const AllocationCount&) = delete;
  AllocationCount& operator=(const AllocationCount&) = delete;

  [[nodiscard]] long count() const;
};

}  // namespace earpoint
