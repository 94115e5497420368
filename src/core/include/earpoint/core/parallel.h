#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>

namespace earpoint {

/// A function reference: no ownership, no allocation. The callee must outlive the call.
template <typename Signature>
class FunctionRef;

template <typename Result, typename... Args>
class FunctionRef<Result(Args...)> {
 public:
  template <typename Callable,
            typename = std::enable_if_t<!std::is_same_v<std::decay_t<Callable>, FunctionRef>>>
  // NOLINTNEXTLINE(google-explicit-constructor): meant to bind to a lambda at the call
  FunctionRef(Callable&& callable)
      : object_(const_cast<void*>(static_cast<const void*>(std::addressof(callable)))),
        call_([](void* object, Args... args) -> Result {
          return (*static_cast<std::remove_reference_t<Callable>*>(object))(
              std::forward<Args>(args)...);
        }) {}
  Result operator()(Args... args) const { return call_(object_, std::forward<Args>(args)...); }

 private:
  void* object_;
  Result (*call_)(void*, Args...);
};

/// A team of threads that waits for loops. The caller works along: a pool of one starts none.
class ThreadPool {
 public:
  /// @param threads  > 0, the caller included
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  [[nodiscard]] int threads() const;

  /// Calls body(task, worker) for every task in [0, tasks), worker in [0, threads()), and returns
  /// when all are done. Tasks are handed out in ascending order to free threads. If bodies
  /// throw, the first exception is rethrown after the loop ends. Allocates nothing.
  /// Not re-entrant, and for one caller at a time.
  void run(std::ptrdiff_t tasks, FunctionRef<void(std::ptrdiff_t task, int worker)> body);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// @return the number of cores that this process may use, at least 1
int available_cores();

}  // namespace earpoint
