#pragma once

// Of the OpenMP runtime that oneDNN runs its threads on.
extern "C" {
void omp_set_num_threads(int threads);
int omp_get_max_threads(void);
}

namespace earpoint::kernels {

/// Sets the number of threads that this thread's oneDNN calls use, for a while.
class OpenMpThreads {
 public:
  explicit OpenMpThreads(int threads) : before_(omp_get_max_threads()) {
    omp_set_num_threads(threads);
  }
  ~OpenMpThreads() { omp_set_num_threads(before_); }
  OpenMpThreads(const OpenMpThreads&) = delete;
  OpenMpThreads& operator=(const OpenMpThreads&) = delete;

 private:
  int before_;
};

}  // namespace earpoint::kernels
