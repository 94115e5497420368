#include "parts.h"

#include <ATen/Parallel.h>
#include <omp.h>

namespace earpoint {

OneThread::OneThread() : threads_before_(at::get_num_threads()) { omp_set_num_threads(1); }
OneThread::~OneThread() { omp_set_num_threads(threads_before_); }

PartTeam::PartTeam() : pool_(at::get_num_threads()) {}

void PartTeam::run(std::ptrdiff_t parts, const std::function<void(std::ptrdiff_t)>& work) {
  pool_.run(parts, [&](std::ptrdiff_t part, int) {
    const OneThread one_thread;
    work(part);
  });
}

}  // namespace earpoint
