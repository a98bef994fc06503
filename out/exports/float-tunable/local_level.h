/*
 * A tuned filter, written by filter-tuner; do not edit it, export it again.
 *
 * schema: "tuner.tuned/1"
 * name: "local_level"
 * filter: "LocalLevel"
 * convention: "discrete"
 * dt: 1.0
 * states: ["level"]
 * versions: {"filter-tuner": "0.1.0", "jax": "0.10.2", "numpy": "2.4.6", "scipy": "1.17.1", "optuna": "5.0.0"}
 * provenance.study: "fit"
 * provenance.problem: "local_level"
 * provenance.solver: "l-bfgs-b"
 * provenance.status: "converged"
 * provenance.seed: 0
 * provenance.log_name: "level.csv"
 * provenance.log_sha256: "84097d6cd88cc4ebd3ff4928b7823ade6322c50532b87edc75ebf2f1a15714ef"
 *
 * Each number is a macro for double, and one for float whose name ends in _F.
 * Vectors and matrices are initialisers, rows first. Units stand above; time is in s.
 */
#ifndef LOCAL_LEVEL_HEADER_INCLUDED
#define LOCAL_LEVEL_HEADER_INCLUDED

/* The sample time, s. */
#define LOCAL_LEVEL_DT 1.0
#define LOCAL_LEVEL_DT_F 1.0f

/* The states and their places. */
#define LOCAL_LEVEL_STATES 1
#define LOCAL_LEVEL_STATE_LEVEL 0

/* quantity: {"name": "q", "unit": "unit^2/s", "meaning": "by how much the level's variance grows in a second: a random walk", "shape": []} */
#define LOCAL_LEVEL_Q 9.680950470805709e-07
#define LOCAL_LEVEL_Q_F 9.68095e-07f

/* quantity: {"name": "R", "unit": "unit^2", "meaning": "variance of a measurement; where sigma is given, a factor without unit on sigma^2", "shape": []} */
#define LOCAL_LEVEL_R 1e-06
#define LOCAL_LEVEL_R_F 1e-06f

/* quantity: {"name": "Q_derived", "unit": "unit^2", "meaning": "variance that the level gains in a sample", "shape": []} */
#define LOCAL_LEVEL_Q_DERIVED 9.680950470805709e-07
#define LOCAL_LEVEL_Q_DERIVED_F 9.68095e-07f

/* quantity: {"name": "K", "unit": "", "meaning": "steady gain on a measurement", "shape": []} */
#define LOCAL_LEVEL_K 0.612491145238
#define LOCAL_LEVEL_K_F 0.61249113f

/* quantity: {"name": "F", "unit": "", "meaning": "what a sample makes of the state, (1, 1): x' = F x", "shape": []} */
#define LOCAL_LEVEL_F 1.0
#define LOCAL_LEVEL_F_F 1.0f

/* quantity: {"name": "C", "unit": "", "meaning": "what is measured of it, (1, 1): z = C x", "shape": []} */
#define LOCAL_LEVEL_C 1.0
#define LOCAL_LEVEL_C_F 1.0f

/*
 * Call init once, and step with every sample, in order. NaN is a missing measurement, so options
 * like -ffast-math, which take NaN away, are refused. Nothing is allocated, there are no globals,
 * and every step takes the same operations, whatever its sample is. Of MISRA C:2012 there are two
 * deviations, both advisory: 2.5, macros of numbers that not everybody needs, and 8.9, constant
 * tables that stand above the functions.
 */
#ifdef __cplusplus
extern "C" {
#endif

/* The state of the filter between samples. */
typedef struct {
    float level;
    float p;
    float known;
    float outside[1];
} local_level_state;

/* The inputs of a sample; NaN where a measurement is missing. */
typedef struct {
    float z; /* measured level, unit */
} local_level_input;

/* The outputs after a sample. */
typedef struct {
    float level; /* estimated level; 0 before the first measurement, unit */
} local_level_output;

/* Its parameters. */
typedef struct {
    float q; /* by how much the level's variance grows in a second: a random walk, unit^2/s */
    float R; /* variance of a measurement; where sigma is given, a factor without unit on sigma^2, unit^2 */
} local_level_params;

/* Values that follow from the parameters, computed by set. */
typedef struct {
    float derived[2];
} local_level_tables;

/* The parameters as they were tuned. */
void local_level_defaults(local_level_params *params);

/* Take parameters over: call it first, and after a change. */
void local_level_set(local_level_tables *tables, const local_level_params *params);

/* Begin anew. */
void local_level_init(local_level_state *state, const local_level_params *params);

/* Take one sample. */
void local_level_step(local_level_state *state,
    const local_level_input *in, local_level_output *out, const local_level_tables *tables);

/* 0, or the number of the first sample that is off; in a file of its own. */
int local_level_selftest(void);

#ifdef __cplusplus
}
#endif

#endif /* LOCAL_LEVEL_HEADER_INCLUDED */
