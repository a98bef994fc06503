/* The likelihood of a linear Kalman filter and its derivatives by the diagonals of Q and R, as a careful
 * engineer writes them for one core: sizes that are known (-DSTATES, -DROWS), measurements one after another,
 * one pass back over what the pass forward kept. P0 is the unit matrix, x0 is 0.
 */
#include <math.h>
#include <stddef.h>
#include <string.h>

enum { N = STATES, M = ROWS, KEPT = N + 2 };
typedef double Matrix[N][N];

/* A P A', by rows, so that the inner loops run along memory. */
static void congruent(const Matrix A, const Matrix across, Matrix P)
{
    Matrix AP;
    for (int i = 0; i < N; i++) {
        double row[N] = {0};
        for (int k = 0; k < N; k++)
            for (int j = 0; j < N; j++) row[j] += A[i][k] * P[k][j];
        memcpy(AP[i], row, sizeof row);
    }
    for (int i = 0; i < N; i++) {
        double row[N] = {0};
        for (int k = 0; k < N; k++)
            for (int j = 0; j < N; j++) row[j] += AP[i][k] * across[k][j];
        memcpy(P[i], row, sizeof row);
    }
}

static void times(const Matrix across, double x[N])
{
    double moved[N] = {0};
    for (int k = 0; k < N; k++)
        for (int i = 0; i < N; i++) moved[i] += across[k][i] * x[k];
    memcpy(x, moved, sizeof moved);
}

static double dot(const double *a, const double *b)
{
    double sum = 0;
    for (int i = 0; i < N; i++) sum += a[i] * b[i];
    return sum;
}

static void product(const Matrix symmetric, const double *h, double *g)
{
    double row[N] = {0};
    for (int k = 0; k < N; k++)
        for (int i = 0; i < N; i++) row[i] += symmetric[k][i] * h[k];
    memcpy(g, row, sizeof row);
}

static double pass(size_t count, const Matrix F, const double *H, const double *q, const double *r, const double *z,
                   double *kept)
{
    Matrix P = {{0}}, across;
    double x[N] = {0}, nats = 0, scratch[KEPT];
    for (int i = 0; i < N; i++) {
        P[i][i] = 1;
        for (int j = 0; j < N; j++) across[j][i] = F[i][j];
    }
    for (size_t t = 0; t < count; t++) {
        congruent(F, across, P);
        times(across, x);
        for (int i = 0; i < N; i++) P[i][i] += q[i];
        for (int i = 0; i < M; i++) {
            double *g = kept ? kept + (t * M + i) * KEPT : scratch;
            product(P, H + i * N, g);
            double s = r[i] + dot(H + i * N, g), weight = 1 / s, y = z[t * M + i] - dot(H + i * N, x);
            for (int a = 0; a < N; a++) {
                x[a] += g[a] * weight * y;
                for (int b = 0; b < N; b++) P[a][b] -= g[a] * weight * g[b];
            }
            g[N] = weight;
            g[N + 1] = y;
            nats += y * y * weight + log(s);
        }
    }
    return nats;
}

void kalman_value(size_t count, const double *F, const double *H, const double *q, const double *r, const double *z,
                  double *out)
{
    out[0] = pass(count, (const double(*)[N])F, H, q, r, z, NULL);
}

/* out: the value, then its derivatives by q and r. kept: room for count * M * (N + 2) numbers. */
void kalman_gradient(size_t count, const double *F, const double *H, const double *q, const double *r,
                     const double *z, double *kept, double *out)
{
    Matrix B = {{0}}, across;
    double X[N] = {0}, *by_q = out + 1, *by_r = by_q + N;
    out[0] = pass(count, (const double(*)[N])F, H, q, r, z, kept);
    memset(by_q, 0, (N + M) * sizeof *by_q);
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) across[j][i] = F[i * N + j];
    for (size_t t = count; t-- > 0;) {
        for (int i = M; i-- > 0;) {
            const double *g = kept + (t * M + i) * KEPT, *h = H + i * N;
            const double w = g[N], y = g[N + 1];
            double u[N], back[N], along = dot(g, X);
            product(B, g, u);
            double by_y = along * w + 2 * y * w, by_s = w - w * w * (along * y + y * y - dot(g, u));
            by_r[i] += by_s;
            for (int a = 0; a < N; a++) back[a] = (X[a] * y - 2 * u[a]) * w + by_s * h[a];
            for (int a = 0; a < N; a++) {
                X[a] -= h[a] * by_y;
                for (int b = 0; b < N; b++) B[a][b] += (back[a] * h[b] + h[a] * back[b]) / 2;
            }
        }
        for (int i = 0; i < N; i++) by_q[i] += B[i][i];
        congruent(across, (const double(*)[N])F, B);
        times((const double(*)[N])F, X);
    }
}
