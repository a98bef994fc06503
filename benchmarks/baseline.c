/* The C limit: Kownacki's gyroscope filter as fast as one core can run it.
 *
 * Phi = [1 T; 0 1], Q T^2 enters both states per sample, the first state is measured, x0 = 0 and
 * P0 is a matrix of ones. The covariance is carried over R (a, b, c for P11, P12, P22) beside its
 * determinant d: of all forms tried this one has the shortest chain from sample to sample, and the
 * chain (add, two fused products, two adds, divide, product) is what a sequential filter costs.
 */
#include <stddef.h>

/* One step of the covariance, for numbers and vectors alike. Leaves a = K1, b = K2, i = 1 - K1. */
#define COVARIANCE(real)                                          \
    real am = a + T * (2 * b + T * c), bm = b + T * c, cm = c + q; \
    real trace = am + cm, dm = d + q * trace;                     \
    am = am + q;                                                  \
    real i = 1.0 / (am + 1.0);                                    \
    a = am * i, b = bm * i, c = (cm + dm) * i, d = dm * i;

/* One signal: the output after each sample. */
void forward(size_t n, double T, double R, double Q, const double *z, double *out)
{
    double q = Q * T * T / R, a = 1 / R, b = a, c = a, d = 0, x0 = 0, x1 = 0;
    for (size_t k = 0; k < n; k++) {
        COVARIANCE(double)
        double xm = x0 + T * x1, y = z[k] - xm;
        out[k] = x0 = xm + a * y;
        x1 = x1 + b * y;
    }
}

/* Two signals side by side through the same gains. */
void two_signals(size_t n, double T, double R, double Q, const double *z, double *out)
{
    double q = Q * T * T / R, a = 1 / R, b = a, c = a, d = 0, x0 = 0, x1 = 0, w0 = 0, w1 = 0;
    for (size_t k = 0; k < 2 * n; k += 2) {
        COVARIANCE(double)
        double xm = x0 + T * x1, y = z[k] - xm, wm = w0 + T * w1, v = z[k + 1] - wm;
        out[k] = x0 = xm + a * y, out[k + 1] = w0 = wm + a * v;
        x1 = x1 + b * y, w1 = w1 + b * v;
    }
}

/* From here on eight pairs (R, Q) to a vector, and a few vectors at once: one alone would wait for
 * its own divisions. m is a multiple of 8 GROUP. */
typedef double lanes __attribute__((vector_size(64)));
typedef double loose __attribute__((vector_size(64), aligned(8))); /* numpy aligns to 8 bytes */
typedef long long mask __attribute__((vector_size(64)));

typedef struct { lanes q, a, b, c, d, x0, x1, sum; } filter; /* or its derivative */
typedef struct { lanes trace, i, y; } passing;             /* what its derivative needs as well */

static inline filter start(const double *R, const double *Q, double T)
{
    lanes r = *(const loose *)R, zero = r - r, p = 1.0 / r;
    return (filter){*(const loose *)Q * T * T / r, p, p, p, zero, zero, zero, zero};
}

static inline passing advance(filter *f, double T, double z)
{
    lanes q = f->q, a = f->a, b = f->b, c = f->c, d = f->d;
    COVARIANCE(lanes)
    lanes xm = f->x0 + T * f->x1, y = z - xm;
    f->a = a, f->b = b, f->c = c, f->d = d;
    f->x0 = xm + a * y, f->x1 = f->x1 + b * y;
    return (passing){trace, i, y};
}

/* The derivative t of f, which has advanced already. */
static inline void follow(filter *t, const filter *f, passing by, double T)
{
    lanes am = t->a + T * (2 * t->b + T * t->c), bm = t->b + T * t->c, cm = t->c + t->q;
    lanes dm = t->d + t->q * by.trace + f->q * (am + cm), xm = t->x0 + T * t->x1;
    am = am + t->q;
    lanes e = -by.i * am;
    t->a = by.i * am + f->a * e, t->b = by.i * bm + f->b * e;
    t->c = by.i * (cm + dm) + f->c * e, t->d = by.i * dm + f->d * e;
    t->x0 = xm + t->a * by.y - f->a * xm, t->x1 = t->x1 + t->b * by.y - f->b * xm;
}

static inline lanes below(double step, lanes x) /* max(step - x, 0) */
{
    lanes lag = step - x;
    return (lanes)((mask)lag & (lag > 0.0));
}

/* The cost of m pairs: squared lag below the step plus power. */
#define GROUP 4
void costs(size_t n, size_t m, double T, const double *R, const double *Q, const double *z,
           const double *step, const double *lag_weight, const double *power_weight, double *cost)
{
    for (size_t g = 0; g < m; g += 8 * GROUP) {
        filter f[GROUP];
        for (int j = 0; j < GROUP; j++) f[j] = start(R + g + 8 * j, Q + g + 8 * j, T);
        for (size_t k = 0; k < n; k++) {
#pragma GCC unroll 4
            for (int j = 0; j < GROUP; j++) {
                advance(f + j, T, z[k]);
                lanes lag = below(step[k], f[j].x0);
                f[j].sum += lag_weight[k] * lag * lag + power_weight[k] * f[j].x0 * f[j].x0;
            }
        }
        for (int j = 0; j < GROUP; j++) *(loose *)(cost + g + 8 * j) = f[j].sum;
    }
}

/* The same with its derivatives by ln R and ln Q. */
#undef GROUP
#define GROUP 2
void gradients(size_t n, size_t m, double T, const double *R, const double *Q, const double *z,
               const double *step, const double *lag_weight, const double *power_weight,
               double *cost, double *by_R, double *by_Q)
{
    for (size_t g = 0; g < m; g += 8 * GROUP) {
        filter f[GROUP], r[GROUP], q[GROUP];
        for (int j = 0; j < GROUP; j++) {
            f[j] = start(R + g + 8 * j, Q + g + 8 * j, T);
            lanes zero = f[j].d;
            r[j] = (filter){-f[j].q, -f[j].a, -f[j].b, -f[j].c, zero, zero, zero, zero};
            q[j] = (filter){f[j].q, zero, zero, zero, zero, zero, zero, zero};
        }
        for (size_t k = 0; k < n; k++) {
#pragma GCC unroll 2
            for (int j = 0; j < GROUP; j++) {
                passing by = advance(f + j, T, z[k]);
                follow(r + j, f + j, by, T);
                follow(q + j, f + j, by, T);
                lanes lag = below(step[k], f[j].x0), power = power_weight[k] * f[j].x0;
                lanes slope = 2 * (power - lag_weight[k] * lag);
                f[j].sum += lag_weight[k] * lag * lag + power * f[j].x0;
                r[j].sum += slope * r[j].x0, q[j].sum += slope * q[j].x0;
            }
        }
        for (int j = 0; j < GROUP; j++) {
            *(loose *)(cost + g + 8 * j) = f[j].sum;
            *(loose *)(by_R + g + 8 * j) = r[j].sum;
            *(loose *)(by_Q + g + 8 * j) = q[j].sum;
        }
    }
}

/* The widest vector this was compiled for, in bits. */
int vector_bits(void)
{
#if defined(__AVX512F__)
    return 512;
#elif defined(__AVX__)
    return 256;
#else
    return 128;
#endif
}
