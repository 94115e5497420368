#pragma once

// What the project uses of C++20's library and Emscripten 3.1.6, which Debian has, does not: its
// libc++ is of version 13. The build puts this before every source. With a libc++ that has them
// (15), nothing of it is seen.
#ifdef __cplusplus
#include <algorithm>
#include <functional>
#include <iterator>
#include <numeric>
#include <type_traits>

#if _LIBCPP_VERSION < 14000
namespace std {

template <typename To, typename From>
[[nodiscard]] constexpr To bit_cast(const From& from) noexcept {
  static_assert(sizeof(To) == sizeof(From));
  return __builtin_bit_cast(To, from);
}

}  // namespace std
#endif

#if _LIBCPP_VERSION < 15000
namespace std::ranges {

template <typename Range, typename Out>
constexpr void copy(Range&& range, Out out) {
  std::copy(std::begin(range), std::end(range), out);
}

template <typename Range, typename Out, typename Test>
constexpr void copy_if(Range&& range, Out out, Test test) {
  std::copy_if(std::begin(range), std::end(range), out, test);
}

template <typename Range, typename Value>
constexpr void fill(Range&& range, const Value& value) {
  std::fill(std::begin(range), std::end(range), value);
}

template <typename Range, typename Out, typename Function>
constexpr void transform(Range&& range, Out out, Function function) {
  std::transform(std::begin(range), std::end(range), out, function);
}

template <typename Range>
constexpr void reverse(Range&& range) {
  std::reverse(std::begin(range), std::end(range));
}

template <typename Range, typename Test>
[[nodiscard]] constexpr bool any_of(Range&& range, Test test) {
  return std::any_of(std::begin(range), std::end(range), test);
}

template <typename Range, typename Test>
[[nodiscard]] constexpr bool all_of(Range&& range, Test test) {
  return std::all_of(std::begin(range), std::end(range), test);
}

template <typename Range, typename Test>
[[nodiscard]] constexpr auto find_if(Range&& range, Test test) {
  return std::find_if(std::begin(range), std::end(range), test);
}

template <typename Range, typename Value, typename Projection = std::identity>
[[nodiscard]] constexpr auto find(Range&& range, const Value& value, Projection of = {}) {
  return std::find_if(std::begin(range), std::end(range),
                      [&](const auto& element) { return std::invoke(of, element) == value; });
}

template <typename Range, typename Value, typename Projection = std::identity>
[[nodiscard]] constexpr auto count(Range&& range, const Value& value, Projection of = {}) {
  return std::count_if(std::begin(range), std::end(range),
                       [&](const auto& element) { return std::invoke(of, element) == value; });
}

template <typename Range, typename Less = std::ranges::less, typename Projection = std::identity>
constexpr void sort(Range&& range, Less less = {}, Projection of = {}) {
  std::sort(std::begin(range), std::end(range), [&](const auto& a, const auto& b) {
    return std::invoke(less, std::invoke(of, a), std::invoke(of, b));
  });
}

template <typename Range, typename Less = std::ranges::less, typename Projection = std::identity>
[[nodiscard]] constexpr auto max_element(Range&& range, Less less = {}, Projection of = {}) {
  return std::max_element(std::begin(range), std::end(range), [&](const auto& a, const auto& b) {
    return std::invoke(less, std::invoke(of, a), std::invoke(of, b));
  });
}

}  // namespace std::ranges
#endif
#endif
