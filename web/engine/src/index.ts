export { Engine, InputError, Stream, compile, readWeights } from './engine';
export type { Box, Picture, Point, Pose, StreamOptions, WasmSource, WeightSource } from './engine';
export { EarpointNode } from './node';
export type { NodeOptions } from './node';
