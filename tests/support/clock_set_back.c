/* The wall clock, set back by an hour half a second after the program starts. Loaded with LD_PRELOAD;
 * monotonic time is left alone, as the kernel leaves it when somebody sets the clock. */
#define _GNU_SOURCE
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

static struct timespec begun;

__attribute__((constructor)) static void begin(void)
{
    syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &begun);
}

int clock_gettime(clockid_t clock, struct timespec *now)
{
    int result = (int)syscall(SYS_clock_gettime, clock, now);
    if (result == 0 && clock == CLOCK_REALTIME) {
        struct timespec monotonic;
        syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &monotonic);
        double elapsed = (double)(monotonic.tv_sec - begun.tv_sec)
                         + 1e-9 * (double)(monotonic.tv_nsec - begun.tv_nsec);
        if (elapsed > 0.5)
            now->tv_sec -= 3600;
    }
    return result;
}
