#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <mutex>
#include <string>

namespace earpoint {

/// Takes reports of how far a long job is. The library only reports; what a user sees is the
/// application's choice. Calls may come from any thread.
class ProgressSink {
 public:
  virtual ~ProgressSink() = default;
  /// @param label  what is being done, e.g. "rendering"
  /// @param total  how many units there are; 0 if not known
  /// @param unit   one unit's name, e.g. "s" or "clips"
  virtual void begin(const std::string& label, double total, const std::string& unit) = 0;
  virtual void advance(double amount) = 0;
  virtual void finish() = 0;
};

/// Says nothing: for --quiet, tests and callers that do not care.
class SilentProgress : public ProgressSink {
 public:
  void begin(const std::string&, double, const std::string&) override {}
  void advance(double) override {}
  void finish() override {}
};

/// A bar with rate and time left on a terminal; plain lines, at most one every ten seconds,
/// elsewhere.
class StreamProgress : public ProgressSink {
 public:
  /// @param stream  where to write, usually stderr; not owned
  explicit StreamProgress(std::FILE* stream);
  /// @param is_terminal  draw a bar in place instead of lines
  StreamProgress(std::FILE* stream, bool is_terminal);

  void begin(const std::string& label, double total, const std::string& unit) override;
  void advance(double amount) override;
  void finish() override;

  /// Writes a separate line between the reports.
  void note(const std::string& line);

 private:
  void draw(bool last);

  std::mutex mutex_;
  std::FILE* stream_;
  bool is_terminal_;
  std::string label_;
  std::string unit_;
  double total_ = 0.0;
  double done_ = 0.0;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point last_draw_;
};

/// "12 s", "3 min 20 s", "2 h 05 min".
std::string format_duration(double seconds);

}  // namespace earpoint
