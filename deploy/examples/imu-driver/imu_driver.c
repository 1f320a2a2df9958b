/* A driver of an inertial measurement unit at 1 kHz: fills a sample, writes its bytes to the socket
 * of `obsid gateway`. The same as src/main.rs, in C.
 *
 *     obsid icd --c-header > obsid_telemetry.h        (or take the one beside this file)
 *     cc -std=c11 -O2 -o imu_driver imu_driver.c
 *     ./imu_driver SOCKET SECONDS [--unpaced]
 *
 * Put the reading of your device into read_device().
 */
#define _POSIX_C_SOURCE 200809L
#include "obsid_telemetry.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

enum { PERIOD_NS = 1000000, TRIES = 1000, ALL_VALID = 0x3f };

/* Angular rate [rad/s] and mean acceleration [m/s^2] of sample k, in body axes. */
static void read_device(uint64_t k, double omega[3], double acceleration[3])
{
    double phase = (double)(k % 1000) / 1000.0;
    omega[2] = 0.02 * phase;
    acceleration[0] = 0.1 * phase;
    acceleration[1] = -0.05;
}

/* Waits for the gateway: it makes the socket, and makes it anew when it is restarted. */
static int connect_to(const char *path)
{
    struct sockaddr_un address = { .sun_family = AF_UNIX };
    const struct timespec pause = { .tv_sec = 0, .tv_nsec = 10 * PERIOD_NS };
    if (strlen(path) >= sizeof address.sun_path)
        return errno = ENAMETOOLONG, -1;
    strcpy(address.sun_path, path);
    for (int tries = 0; tries < TRIES; tries++) {
        int fd = socket(AF_UNIX, SOCK_STREAM, 0);
        if (fd < 0 || connect(fd, (struct sockaddr *)&address, sizeof address) == 0)
            return fd;
        close(fd);
        nanosleep(&pause, NULL);
    }
    return -1;
}

static int write_all(int fd, const void *bytes, size_t count)
{
    for (size_t done = 0; done < count;) {
        ssize_t written = write(fd, (const char *)bytes + done, count - done);
        if (written < 0 && errno != EINTR)
            return -1;
        done += written > 0 ? (size_t)written : 0;
    }
    return 0;
}

int main(int argc, char **argv)
{
    int paced = argc < 4 || strcmp(argv[3], "--unpaced") != 0;
    if (argc < 3) {
        fprintf(stderr, "usage: imu_driver SOCKET SECONDS [--unpaced]\n");
        return 2;
    }
    signal(SIGPIPE, SIG_IGN);
    uint64_t count = 1000 * strtoull(argv[2], NULL, 10), lost = 0;
    int fd = connect_to(argv[1]);
    struct timespec due;
    clock_gettime(CLOCK_MONOTONIC, &due);
    for (uint64_t k = 0; k < count && fd >= 0; k++) {
        obsid_imu sample = { .interval_s = PERIOD_NS / 1e9, .valid = ALL_VALID };
        sample.header.layout = OBSID_LAYOUT_IMU;
        sample.header.t_meas_ns = k * PERIOD_NS;
        read_device(k, sample.omega_bi_b_rad_s, sample.acceleration_b_m_s2);
        if (paced)
            clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, NULL);
        if ((due.tv_nsec += PERIOD_NS) >= 1000000000) {
            due.tv_nsec -= 1000000000;
            due.tv_sec++;
        }
        if (write_all(fd, &sample, sizeof sample) != 0) {
            lost++;
            close(fd);
            fd = connect_to(argv[1]);
        }
    }
    if (fd < 0) {
        perror(argv[1]);
        return 1;
    }
    close(fd);
    printf("%llu samples written, %llu lost\n", (unsigned long long)(count - lost), (unsigned long long)lost);
    return 0;
}
