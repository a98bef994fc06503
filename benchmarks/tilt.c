/* The extended Kalman filter of filters/tilt_euler.py (two-step law, nonlinear residual) as a careful
 * engineer writes it for one core: fixed sizes, scalar measurements one after another, no solve.
 */
#include <math.h>
#include <stddef.h>
#include <string.h>

enum { N = 5 };

static void update(double x[N], double P[N][N], const double h[N], double r, double y)
{
    double g[N], s = r;
    for (int i = 0; i < N; i++) {
        g[i] = 0;
        for (int j = 0; j < N; j++) g[i] += P[i][j] * h[j];
    }
    for (int i = 0; i < N; i++) s += h[i] * g[i];
    double weight = 1 / s;
    for (int i = 0; i < N; i++) {
        x[i] += g[i] * weight * y;
        for (int j = 0; j < N; j++) P[i][j] -= g[i] * g[j] * weight;
    }
}

/* x = F x, P = F P F' + Q, with F and Q of (4). */
static void predict(double x[N], double P[N][N], double q1, double T)
{
    double s = sin(x[1]), c = cos(x[1]), t = tan(x[0]);
    double W[2][3] = {{0, c, -s}, {1, s * t, c * t}};
    double F[N][N] = {{0}}, Q[N][N] = {{0}}, FP[N][N], moved[N] = {0};
    for (int i = 0; i < N; i++) F[i][i] = 1;
    for (int i = 0; i < 2; i++) {
        for (int j = 0; j < 3; j++) {
            F[i][2 + j] = W[i][j] * T;
            Q[i][2 + j] = Q[2 + j][i] = q1 * T * T / 2 * W[i][j];
        }
        for (int j = 0; j < 2; j++)
            for (int k = 0; k < 3; k++) Q[i][j] += q1 * T * T * T / 3 * W[i][k] * W[j][k];
    }
    for (int i = 2; i < N; i++) Q[i][i] = q1 * T;
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) {
            moved[i] += F[i][j] * x[j];
            FP[i][j] = 0;
            for (int k = 0; k < N; k++) FP[i][j] += F[i][k] * P[k][j];
        }
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) {
            P[i][j] = Q[i][j];
            for (int k = 0; k < N; k++) P[i][j] += FP[i][k] * F[j][k];
        }
    memcpy(x, moved, sizeof moved);
}

/* noise: q1, r_nom, r_nom, r3, alpha1, alpha2; out: (theta, phi) after each sample. */
void tilt(size_t n, double T, double delta, double P0, const double *acceleration,
          const double *rate, const double *noise, double *out)
{
    double q1 = noise[0], r3 = noise[3], alpha1 = noise[4], alpha2 = noise[5];
    double x[N] = {0}, P[N][N] = {{0}}, r[2] = {noise[1], noise[2]};
    for (int i = 0; i < N; i++) P[i][i] = P0;
    for (size_t k = 0; k < n; k++) {
        const double *a = acceleration + 3 * k, *w = rate + 3 * k;
        predict(x, P, q1, T);
        double C[2][N] = {{cos(x[0])}, {-sin(x[1]) * sin(x[0]), cos(x[1]) * cos(x[0])}};
        for (int i = 0; i < 3; i++) {
            double h[N] = {0};
            h[2 + i] = 1;
            update(x, P, h, r3, w[i] - x[2 + i]);
        }
        double e[2] = {a[0] - sin(x[0]), a[1] - sin(x[1]) * cos(x[0])}, at[N];
        int disturbed = fabs(a[0] * a[0] + a[1] * a[1] + a[2] * a[2] - 1) > delta;
        memcpy(at, x, sizeof at);
        for (int i = 0; i < 2; i++) {
            double nominal = noise[1 + i], grown = alpha1 * r[i] + alpha2 * fabs(e[i]);
            r[i] = disturbed ? fmax(grown, nominal) : alpha1 * r[i] + nominal;
            double y = e[i];
            for (int j = 0; j < N; j++) y -= C[i][j] * (x[j] - at[j]);
            update(x, P, C[i], r[i], y);
        }
        out[2 * k] = x[0], out[2 * k + 1] = x[1];
    }
}
