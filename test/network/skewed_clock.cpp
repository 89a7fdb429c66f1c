// Preloaded into a process: its wall clock is off by what the file SKEWED_CLOCK holds, a double [s],
// which may change while it runs. Its monotonic clock, and whatever sleeps by it, is not touched, as
// when somebody sets a computer's clock. (libfaketime 0.9.10 makes Python's time.sleep fail.)
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <time.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace {

constexpr std::int64_t kSecond = 1000000000;

std::int64_t skew() {  // [ns]
  static const volatile double* const seconds = [] {
    const int file = open(std::getenv("SKEWED_CLOCK"), O_RDONLY | O_CLOEXEC);
    void* const at = mmap(nullptr, sizeof(double), PROT_READ, MAP_SHARED, file, 0);
    if (at == MAP_FAILED) std::abort();
    return static_cast<const volatile double*>(at);
  }();
  return std::llround(*seconds * 1e9);
}

template <typename Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

timespec shifted(const timespec& time, std::int64_t by) {
  const std::int64_t sum = time.tv_sec * kSecond + time.tv_nsec + by;
  return {static_cast<time_t>(sum / kSecond), static_cast<long>(sum % kSecond)};
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* out) noexcept {
  static const auto real = next<int (*)(clockid_t, timespec*)>("clock_gettime");
  const int result = real(clock, out);
  if (result == 0 && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE))
    *out = shifted(*out, skew());
  return result;
}

int gettimeofday(timeval* out, void*) noexcept {
  timespec now;
  const int result = clock_gettime(CLOCK_REALTIME, &now);
  *out = {now.tv_sec, now.tv_nsec / 1000};
  return result;
}

time_t time(time_t* out) noexcept {
  timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (out) *out = now.tv_sec;
  return now.tv_sec;
}

int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                           const timespec* until) {
  static const auto real =
      next<int (*)(pthread_cond_t*, pthread_mutex_t*, clockid_t, const timespec*)>(
          "pthread_cond_clockwait");
  const timespec end = clock == CLOCK_REALTIME ? shifted(*until, -skew()) : *until;
  return real(condition, mutex, clock, &end);
}

}  // extern "C"
