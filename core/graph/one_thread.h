// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Keeps CHOLMOD on the caller's thread for as long as it lives. CHOLMOD asks OpenMP for four threads whatever there is to do;
// for factors of small blocks their meeting takes longer than the work. Where parallel regions may not nest even once, each of
// them is the caller's alone.

extern "C" {
int omp_get_max_active_levels();
void omp_set_max_active_levels(int levels);
}

namespace covey::graph {

class OneThread {
 public:
  OneThread() : levels_before_(omp_get_max_active_levels()) { omp_set_max_active_levels(0); }
  ~OneThread() { omp_set_max_active_levels(levels_before_); }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int levels_before_;
};

}  // namespace covey::graph
